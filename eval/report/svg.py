"""A matplotlib figure as SVG text that lives inside a page: its colours, its font, and names of its own."""

from __future__ import annotations

import html
import io
import re

from matplotlib.figure import Figure

from eval.report import drawing

_CSS = {
    drawing.INK: "currentColor",
    drawing.GRID: "var(--grid)",
    drawing.REFERENCE: "var(--muted)",
    "stroke: #ffffff": "stroke: var(--page)",
}
_NAME = re.compile(r'(\bid="|url\(#|href="#)')
_PATH = re.compile(r'\bd="[^"]*"')
_LONG_NUMBER = re.compile(r"-?\d+\.\d{2,}")
# What the page says once, or nobody refers to: metadata, a style for all of the page, names of groups, fonts.
_NOT_WANTED = re.compile(
    r'<metadata>.*?</metadata>|<style.*?</style>|(?<=<g) id="[^"]*"| font-family: [^;"]*;|^\s+',
    re.DOTALL | re.MULTILINE,
)


def inline(figure: Figure, name: str, label: str) -> str:
    """The figure as an <svg> element of class `figure`, as wide as the page allows.

    Args:
        figure: drawn in `eval.report.drawing.style`.
        name: unique on the page; every id inside begins with it.
        label: what a screen reader says.
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
    for colour, css in _CSS.items():
        body = body.replace(colour, css)
    return (
        f'<svg viewBox="{opening.group(1)}" role="img" aria-label="{html.escape(label)}" class="figure" '
        f'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink">{body}'
    )


def _shorter(number: re.Match[str]) -> str:
    """A coordinate to a tenth of a point, which is less than a pixel."""
    return f"{float(number.group()):.1f}"
