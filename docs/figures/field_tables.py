"""Tables of settings that are numbers, made of their fields and of what the docstring of their class says of each."""

from __future__ import annotations

import re
from collections.abc import Mapping
from inspect import cleandoc

from jawenv.numeric_fields import NumericFields

ATTRIBUTE = re.compile(r"^    (\w[\w, ]*): (.+(?:\n {8,}.+)*)", re.M)


def fields_table(kind: type[NumericFields], shown: Mapping[str, NumericFields]) -> str:
    """A row for each attribute of the docstring: its values, the highest ones, its meaning.

    Args:
        kind: the class.
        shown: heading of a column -> the object whose values stand in it.
    """
    heads = ["field", *shown, "at most", "meaning (grade)"]
    lines = [heads, ["---", *("--:" for _ in shown), "--:", "---"]]
    for names, meaning in ATTRIBUTE.findall(cleandoc(kind.__doc__ or "").split("Attributes:")[1]):
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
