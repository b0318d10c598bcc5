"""Photograph a patient's page, as the README shows it: ``python docs/figures/draw_patient.py``; it needs a Chromium."""

from __future__ import annotations

import io
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image
from playwright.sync_api import sync_playwright

FIGURE = Path(__file__).parent / "patient.jpg"
COMMAND = "patient apg_anyone --cohort one_sided --seed 500"
WIDTH, HEIGHT = 1080, 1240


def main() -> None:
    """Write ``FIGURE``: the top of the page that ``COMMAND`` writes."""
    browser = next(path for path in map(shutil.which, ("chromium", "chromium-browser", "google-chrome")) if path)
    with TemporaryDirectory() as folder, sync_playwright() as playwright:
        command = [sys.executable, "-m", "eval", *COMMAND.split(), "--output", folder]
        subprocess.run(command, cwd=FIGURE.parents[2], check=True, timeout=3600)
        (page,) = Path(folder).glob("patient-*.html")
        tab = playwright.chromium.launch(executable_path=browser, args=["--no-sandbox"]).new_page(
            viewport={"width": WIDTH, "height": HEIGHT}, color_scheme="light"
        )
        tab.goto(page.as_uri())
        tab.wait_for_timeout(2000)
        Image.open(io.BytesIO(tab.screenshot())).convert("RGB").save(FIGURE, quality=88)


if __name__ == "__main__":
    main()
