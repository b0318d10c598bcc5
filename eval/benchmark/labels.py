"""Texts of a submission that people read: in one line, and labels of plain signs alone."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator, Field

from jawenv.base.errors import shown

LONGEST_LABEL = 60
_NO_LABEL = re.compile(r"[^A-Za-z0-9 ._()-]+")


def printable(text: str) -> str:
    """The text itself.

    Raises:
        ValueError: it has more than one line, or characters that steer a terminal.
    """
    if not text.isprintable():
        raise ValueError(f"is {shown(text)}; allowed: one line of printable characters")
    return text


def label_of(name: str) -> str:
    """The label of an agent by its name: letters, digits, blanks and ``._-()``, 60 at most."""
    return _NO_LABEL.sub("-", name)[:LONGEST_LABEL].strip() or "agent"


def numbered(label: str, number: int) -> str:
    """The label of one among several agents of one name."""
    end = f" ({number})"
    return label[: LONGEST_LABEL - len(end)] + end


def is_label_of(label: str, name: str) -> bool:
    """Whether a label is that of a name, numbered or not."""
    own, number = label_of(name), re.search(r" \((\d{1,3})\)$", label)
    return label == own or (number is not None and label == numbered(own, int(number[1])))


def _plain(label: str) -> str:
    if label != label_of(label):
        signs = "printable letters, digits, blanks and ._-()"
        raise ValueError(f"is {shown(label)}; allowed: {signs}, {LONGEST_LABEL} at most")
    return label


Text = Annotated[str, Field(min_length=1, max_length=1000), AfterValidator(printable)]
Label = Annotated[str, AfterValidator(_plain)]
