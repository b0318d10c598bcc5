"""HTML files out of templates, which need no network and no other file; their figures and terms."""

from __future__ import annotations

import html
import io
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape
from markupsafe import Markup, escape
from matplotlib.figure import Figure

from eval.figures import words
from eval.report import drawing
from jawenv.base.files import write_text

TEMPLATES = Path(__file__).parent / "templates"
TERMS = {
    "NEES": (
        "Normalised estimation error squared: the squared error in units of what the filter states, summed over the "
        "parameters. On average it is their number if the filter is calibrated; more means too sure."
    ),
    "nats": "The unit of information: one more nat, and all sds together have shrunk by a factor of e = 2.72.",
    "sd": "Standard deviation that the filter states: it is probably within so much of the truth.",
    "sds": "Standard deviations that the filter states: it is probably within so much of the truth.",
    "RMSE": "Root mean square error: the typical distance of the estimates from the truth.",
    "bound": "Posterior Cramér–Rao bound: the least error that any unbiased estimator could reach with that maneuver.",
    "misfit": "How badly the readings fit the model that the filter believes in; where it is large, the alarm rings.",
    "alarm": "It rings where the misfit is large: then nothing that the filter knows of explains the readings.",
}
_COLOURS = {
    drawing.INK: "currentColor",
    drawing.GRID: "var(--grid)",
    drawing.REFERENCE: "var(--muted)",
    "stroke: #ffffff": "stroke: var(--page)",
}
_TERM = re.compile(rf"\b({'|'.join(TERMS)})\b")
_NAME = re.compile(r'(\bid="|url\(#|href="#)')
_PATH = re.compile(r'\bd="[^"]*"')
_LONG_NUMBER = re.compile(r"-?\d+\.\d{2,}")
# Dropped as repeated or unused: metadata, a style for all of the page, names of groups, fonts.
_NOT_WANTED = re.compile(
    r'<metadata>.*?</metadata>|<style.*?</style>|(?<=<g) id="[^"]*"| font-family: [^;"]*;|^\s+',
    re.DOTALL | re.MULTILINE,
)


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
        "with_interval": words.with_interval,
        "label": words.label,
        "raw": words.raw,
        "term": term,
        "scaled": words.scaled,
        "with_terms": with_terms,
    }
    return environment.get_template(name).render(**values)


def term(word: str) -> Markup:
    """A term as an element that explains it under the pointer.

    Raises:
        KeyError: a word that is not among ``TERMS``.
    """
    return Markup('<abbr title="{}">{}</abbr>').format(TERMS[word], word)


def with_terms(text: str) -> Markup:
    """A text in lines, its terms explained under the pointer."""
    parts = (term(part) if part in TERMS else escape(part) for part in _TERM.split(text))
    return Markup("").join(parts).replace("\n", Markup("<br>"))


def write(page: str, path: Path) -> Path:
    """Write a page, wholly or not at all.

    Returns:
        The path.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, page)
    return path


def picture(figure: Figure, name: str, label: str, colours: Mapping[str, str] | None = None) -> Markup:
    """A matplotlib figure as an <svg> element of class `figure`, in the page's font and colours.

    Args:
        figure: drawn in `eval.report.drawing.style`.
        name: unique on the page; every id inside begins with it.
        label: text for a screen reader.
        colours: drawn colour -> CSS, besides those of `eval.report.drawing`.
    """
    with drawing.style():
        written = io.StringIO()
        figure.savefig(written, format="svg", metadata={"Date": None, "Creator": None})
    text = written.getvalue()
    opening = re.search(r'<svg[^>]*viewBox="([^"]*)"[^>]*>', text, re.DOTALL)
    assert opening is not None, "matplotlib writes an <svg> with a viewBox"
    body = _NOT_WANTED.sub("", text[opening.end() :])
    body = _PATH.sub(lambda path: _LONG_NUMBER.sub(_shorter, path.group()).replace("\n", ""), body)
    body = _NAME.sub(rf"\g<1>{name}-", body)
    for colour, css in (_COLOURS | dict(colours or {})).items():
        body = body.replace(colour, css)
    return Markup(  # noqa: S704  (our own figure; the label is escaped)
        f'<svg viewBox="{opening.group(1)}" role="img" aria-label="{html.escape(label)}" class="figure" '
        f'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink">{body}'
    )


def _shorter(number: re.Match[str]) -> str:
    """A coordinate to a tenth of a point, less than a pixel."""
    return f"{float(number.group()):.1f}"
