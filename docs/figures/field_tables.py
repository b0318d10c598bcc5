"""Tables of settings that are numbers, made of their fields and of what stands with each or in the docstring."""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping
from inspect import cleandoc, getsource
from itertools import pairwise
from textwrap import dedent

from jawenv.base.numeric_fields import NumericFields

ATTRIBUTE = re.compile(r"^    (\w[\w, ]*): (.+(?:\n {8,}.+)*)", re.M)


def descriptions(kind: type[NumericFields]) -> list[tuple[str, str]]:
    """Names, which may be several with commas between them, and what is said of them."""
    _, found, attributes = cleandoc(kind.__doc__ or "").partition("Attributes:")
    if found:
        return ATTRIBUTE.findall(attributes)
    source = dedent(getsource(kind))
    (body,) = (node.body for node in ast.parse(source).body if isinstance(node, ast.ClassDef))
    lines, told = source.splitlines(), []
    for node, after in pairwise([*body, ast.Pass()]):
        if not isinstance(node, ast.AnnAssign):
            continue
        below = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
        behind = lines[node.end_lineno - 1][node.end_col_offset :].partition("# ")[2]
        told.append((node.target.id, str(after.value.value) if below else behind))
    return told


def fields_table(kind: type[NumericFields], shown: Mapping[str, NumericFields]) -> str:
    """A row for each field: its values, the highest ones, its meaning.

    Args:
        kind: the class.
        shown: heading of a column -> the object whose values stand in it.
    """
    heads = ["field", *shown, "at most", "meaning (grade)"]
    lines = [heads, ["---", *("--:" for _ in shown), "--:", "---"]]
    for names, meaning in descriptions(kind):
        fields = names.split(", ")
        values = [_joined(getattr(one, name) for name in fields) for one in shown.values()]
        highest = _joined(kind.numeric_fields()[name].high for name in fields)
        text = " ".join(meaning.replace("``", "`").split()).rstrip(".")
        lines.append([", ".join(f"`{name}`" for name in fields), *values, highest, text])
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def _joined(values: object) -> str:
    """Numbers as they stand in a cell; one where all are equal."""
    texts = [f"{value:,g}" for value in values]  # type: ignore[attr-defined]
    return texts[0] if len(set(texts)) == 1 else ", ".join(texts)
