"""HTML files out of templates; they need no network and no other file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape
from markupsafe import Markup
from matplotlib.figure import Figure

from eval import words
from eval.report import svg, terms
from jawenv.files import write_text

TEMPLATES = Path(__file__).parent / "templates"


def render(name: str, folder: Path = TEMPLATES, **values: Any) -> str:
    """The page that a template of a folder gives with these values."""
    environment = Environment(
        loader=FileSystemLoader(folder),
        autoescape=select_autoescape(("html.j2",), default=True),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "number": words.number,
        "percent": words.percent,
        "interval": words.interval,
        "label": words.label,
        "raw": words.raw,
        "term": terms.term,
        "explained": terms.explained,
        "in_percent": lambda estimate: words.scaled(estimate, 100.0),
    }
    return environment.get_template(name).render(**values)


def write(page: str, path: Path) -> Path:
    """Write a page, wholly or not at all.

    Returns:
        The path.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, page)
    return path


def picture(figure: Figure, name: str, label: str) -> Markup:
    """A figure as part of a page, see `eval.report.svg.inline`."""
    return Markup(svg.inline(figure, name, label))  # noqa: S704  (our own figure, ids and label are escaped)
