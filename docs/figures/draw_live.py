"""Photograph the live page after a drive, as the README shows it: ``python docs/figures/draw_live.py``.

It needs a Chromium; Playwright drives it.
"""

from __future__ import annotations

import io
import shutil
import sys
import threading
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image
from playwright.sync_api import sync_playwright

ROOT = Path(__file__).parents[2]
if str(ROOT) not in sys.path:
    sys.path.append(str(ROOT))

from jawenv.live.page import Page  # noqa: E402
from jawenv.live.server import serving, url_of  # noqa: E402
from jawenv.live.setup import Setup  # noqa: E402

FIGURE = Path(__file__).parent / "live.jpg"
DRIVER, COHORT, SEED, BUDGET_S = "apg_anyone", "one_sided", 500, 0.1
WIDTH, HEIGHT, WAIT_MS = 1280, 640, 6000
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


def driven(page: Page) -> None:
    """Drive an episode to its end."""
    page._start()
    while not page.session.ended:
        page.step()


def main() -> None:
    """Write ``FIGURE``."""
    browser = next(path for path in map(shutil.which, ("chromium", "chromium-browser", "google-chrome")) if path)
    with TemporaryDirectory() as folder, serving(0) as server, sync_playwright() as playwright:
        page = Page(server, Setup.of(seed=SEED, cohort=COHORT, comfort_budget_s=BUDGET_S), Path(folder), driver=DRIVER)
        driven(page)
        page._view._colour.value = "how stiff"
        page._show()
        thread = threading.Thread(target=page.run, daemon=True)
        thread.start()
        tab = playwright.chromium.launch(executable_path=browser, args=FLAGS).new_page(
            viewport={"width": WIDTH, "height": HEIGHT}, color_scheme="light"
        )
        tab.goto(url_of(server))
        tab.wait_for_selector("#score", timeout=60_000)
        tab.locator(".mantine-Notification-closeButton").first.click()  # it draws without a graphics card
        tab.wait_for_timeout(WAIT_MS)
        picture = Image.open(io.BytesIO(tab.screenshot())).convert("RGB")
        page.stop()
        thread.join(10)
    picture.save(FIGURE, quality=88)


if __name__ == "__main__":
    main()
