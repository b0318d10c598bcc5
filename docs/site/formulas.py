"""Formulas between dollars as MathML, which browsers draw without a script."""

from __future__ import annotations

import re

from latex2mathml.converter import convert

PIECE = re.compile(r"^```.*?^```|`[^`\n]+`|\$\$(?P<block>.+?)\$\$|\$(?=\S)(?P<inline>[^$]+?)(?<=\S)\$", re.S | re.M)
MATRIX = re.compile(r"<mo>(&#x00028;|&#x0005B;)</mo>(<mtable>.*?</mtable>)<mo>(&#x00029;|&#x0005D;)</mo>")
FUNCTION = re.compile(
    r"(<mi>(?:arccos|arctan|cos|det|exp|ln|log|max|min|sin|tan)</mi>)(?=<m(?:i|n|sub|sup|over|frac|subsup)>)"
)
MEANT = str.maketrans({sign: f"&#{ord(sign)};" for sign in "*_|[]\\`~^"})
"""Signs to which Markdown would give a meaning of its own."""


def with_mathml(markdown: str) -> str:
    """A page with its formulas drawn; code is left as it is."""
    return PIECE.sub(_drawn, markdown)


def _drawn(piece: re.Match[str]) -> str:
    if piece["block"]:
        return _mathml(piece["block"], "block")
    if piece["inline"]:
        return f"<span>{_mathml(piece['inline'], 'inline').translate(MEANT)}</span>"
    return piece[0]


def _mathml(formula: str, display: str) -> str:
    """One line; brackets grow with their matrix, and a function keeps off its argument."""
    maths = " ".join(str(convert(formula, display=display)).split())
    maths = MATRIX.sub(r'<mrow><mo form="prefix">\1</mo>\2<mo form="postfix">\3</mo></mrow>', maths)
    return FUNCTION.sub(r'\1<mspace width="0.17em"/>', maths)
