"""Pages that the commands write, as examples on the site: ``python docs/site/example_pages.py`` makes them first.

They lie in runs/examples; a command that is given again makes only what has changed. With JAWENV_NOTEBOOK_QUICK=1 they
are small. What was not made is shown by its command alone.
"""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
KEPT = ROOT / "runs" / "examples"
QUICK = bool(int(os.environ.get("JAWENV_NOTEBOOK_QUICK", "0")))


@dataclass(frozen=True)
class Example:
    """A command, and the page that it writes.

    Attributes:
        name: of its folder, and of its page on the site.
        title: above it.
        says: what the reader finds there.
        command: after ``python -m eval``, without the output.
        quick: the same, as small as it can be.
        page: which of the written files is shown.
    """

    name: str
    title: str
    says: str
    command: str
    quick: str
    page: str = "report.html"


EXAMPLES = (
    Example(
        "comparison",
        "The report of a comparison",
        "Which maneuver is best, how soon it knows all, whether that can be believed; then every figure behind it.",
        "compare refined ppo_trismus opening_with_swings_and_fore_aft slow_opening hold_still random "
        "--patients 32 --seed 500",
        "compare refined slow_opening --patients 4 --episode-s 3",
    ),
    Example(
        "patient",
        "A patient's page",
        "Which muscle is stiff or blocked, how sure that is, and how it became known over three treatments.",
        "patient opening_with_swings_and_fore_aft --cohort one_sided --treatments 3 --seed 3",
        "patient slow_opening --cohort one_sided --seed 3 --episode-s 3",
        "patient-3.html",
    ),
)


def make_all() -> int:
    """Run every command; a second time it takes seconds.

    Returns:
        The exit code: 0, or that of the command that failed.
    """
    for example in EXAMPLES:
        words = shlex.split(example.quick if QUICK else example.command)
        done = subprocess.run([sys.executable, "-m", "eval", *words, "--output", str(KEPT / example.name)], cwd=ROOT)
        if done.returncode:
            return done.returncode
    return 0


def files() -> dict[str, bytes]:
    """Place in the site -> content, of the pages that were made."""
    places = {f"examples/{example.name}.html": KEPT / example.name / example.page for example in EXAMPLES}
    return {name: place.read_bytes() for name, place in places.items() if place.exists()}


def page() -> str:
    """The overview as Markdown."""
    made = files()
    parts = [
        "---\nhide: [toc]\n---",
        "# Examples and notebooks",
        "Open a page as a command writes it: each is one file that needs no network. Or read a notebook below.",
        '<div class="ways" markdown>',
    ]
    for example in EXAMPLES:
        name = f"examples/{example.name}.html"
        link = f"[Open the page]({name}){{ .md-button }}" if name in made else "`make docs` makes it."
        command = f"```sh\npython -m eval {example.command}\n```"
        card = [f"### {example.title}", example.says, link, command]
        parts += ['<div class="card" markdown>', *card, "</div>"]
    return "\n\n".join([*parts, "</div>", "## Notebooks", _notebooks()]) + "\n"


def _notebooks() -> str:
    """A line for each notebook, by the heading of its own."""
    lines = []
    for path in sorted((ROOT / "eval" / "notebooks").glob("*.ipynb")):
        source = json.loads(path.read_text(encoding="utf-8"))["cells"][0]["source"]
        title = "".join(source).splitlines()[0].lstrip("# ")
        lines.append(f"- [{title}](notebooks/{path.stem}.md)")
    return "With what they print and draw; `make notebooks` opens them.\n\n" + "\n".join(lines)


if __name__ == "__main__":
    try:
        sys.exit(make_all())
    except KeyboardInterrupt:
        sys.exit("stopped; what is finished is kept, and the same command goes on")
