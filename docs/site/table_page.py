"""All tables of docs/tables on one page."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

FOLDER = Path(__file__).parents[1] / "tables"
TABLES = sorted(FOLDER.glob("*.md"))
FIRST = "Look up every figure of the studies here, each table under the command that made it."
HEADING = re.compile(r"^(#+) (.+)$", re.M)


def page(texts: Mapping[str, str]) -> str:
    """The tables one after the other, each under its title.

    Args:
        texts: name of each table's file, without its suffix -> its Markdown.
    """
    titles = {name: HEADING.search(text)[2] for name, text in texts.items()}  # type: ignore[index]
    contents = "\n".join(f"- [{title}](#{anchor(name, '')})" for name, title in titles.items())
    bodies = [_lowered(name, text.strip()) for name, text in texts.items()]
    return "\n\n".join(["# Tables", FIRST, contents, *bodies]) + "\n"


def first_table(text: str) -> list[dict[str, str]]:
    """The rows of a page's first table, each as heading -> cell."""
    lines = re.search(r"(?:^\|.*\n)+", text, re.M)[0].splitlines()  # type: ignore[index]
    heads, _, *rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return [dict(zip(heads, row, strict=True)) for row in rows]


def anchor(name: str, heading: str) -> str:
    """Where a table stands on the page, or a section of it, whose own anchor is ``heading``."""
    return f"{name}-{heading}" if heading else name


def _lowered(name: str, text: str) -> str:
    """The headings one level lower, with anchors that no other table has."""

    def heading(found: re.Match[str]) -> str:
        own = "" if found[1] == "#" else re.sub(r"[^\w\- ]", "", found[2].lower()).replace(" ", "-")
        return f"#{found[0]} {{#{anchor(name, own)}}}"

    return HEADING.sub(heading, text)
