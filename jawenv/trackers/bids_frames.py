"""Reference frames of BIDS-Motion, as ``*_channels.json`` describes them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from jawenv.base.errors import InputError, shown
from jawenv.base.files import read_mapping
from jawenv.trackers.tracks import Array

DIRECTIONS = {"A": (1, 0, 0), "P": (-1, 0, 0), "L": (0, 1, 0), "R": (0, -1, 0), "S": (0, 0, 1), "I": (0, 0, -1)}
"""Letters of SpatialAxes in forward, left and up."""
RULES = ("right-hand", "left-hand")
ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


@dataclass(frozen=True, eq=False)
class Frame:
    """One level of the column ``reference_frame``."""

    axes: Array | None = None  # (3, 3) from the file's axes to forward, left and up; None where they are not stated
    rule: str | None = None  # which hand's fingers follow a positive rotation; None likewise
    rotation_order: str | None = None  # of Euler angles about axes at rest; None likewise

    def sign(self, path: str) -> float:
        """1 where a positive turn about z leads from x to y, -1 where it leads from y to x."""
        mirrored = self.axes is not None and np.linalg.det(self.axes) < 0.0
        if mirrored and self.rule is None:
            raise InputError(f"{path}: RotationRule is missing; allowed with left-handed axes: {' or '.join(RULES)}")
        if self.axes is None and self.rule == RULES[1]:
            raise InputError(f"{path}: SpatialAxes is missing; allowed with a left-hand rule: letters as ARS")
        return -1.0 if (self.rule == RULES[1]) != mirrored else 1.0

    def order(self, path: str) -> str:
        """The order of Euler angles."""
        if self.rotation_order is None:
            raise InputError(f"{path}: RotationOrder is missing; allowed with angles: {', '.join(ORDERS)}")
        return self.rotation_order


@dataclass(frozen=True)
class Frames:
    """All levels by their names."""

    levels: Mapping[str, Frame]

    def of(self, name: str) -> Frame:
        """The frame that a channel names; of one that names none the only frame there is."""
        if name.lower() in ("", "n/a"):
            return next(iter(self.levels.values())) if len(self.levels) == 1 else Frame()
        return self.levels.get(name, Frame())


def read_frames(path: Path) -> Frames:
    """Read ``*_channels.json``; a level may be a mapping, or a text for people. No file is no frame."""
    if not path.exists():
        return Frames({})
    described = read_mapping(path).get("reference_frame", {})
    if not isinstance(described, dict):
        raise InputError(f"{path}: reference_frame is {shown(described)}; allowed: a mapping with Levels")
    levels = described.get("Levels", {})
    if not isinstance(levels, dict):
        raise InputError(f"{path}: Levels is {shown(levels)}; allowed: a mapping of names to frames")
    return Frames({name: _frame(level, str(path)) for name, level in levels.items() if isinstance(level, dict | str)})


def _frame(level: dict[str, Any] | str, path: str) -> Frame:
    if isinstance(level, str):
        return Frame()
    rule, order = (_word(level, "RotationRule", RULES, path), _word(level, "RotationOrder", ORDERS, path))
    stated = level.get("SpatialAxes", "n/a")
    if stated == "n/a":
        return Frame(None, rule, order)
    letters = stated if isinstance(stated, str) and len(stated) == len(ORDERS[0]) else ""
    axes = np.array([DIRECTIONS.get(letter, (0, 0, 0)) for letter in letters], dtype=np.float64).T
    if axes.shape != (3, 3) or abs(round(float(np.linalg.det(axes)))) != 1:
        raise InputError(
            f"{path}: SpatialAxes is {shown(stated)}; allowed: three letters of A or P, L or R, S or I, as ALS"
        )
    return Frame(axes, rule, order)


def _word(level: Mapping[str, Any], name: str, words: tuple[str, ...], path: str) -> str | None:
    value = level.get(name, "n/a")
    if value == "n/a":
        return None
    word = next((word for word in words if isinstance(value, str) and value.casefold() == word.casefold()), None)
    if word is None:
        raise InputError(f"{path}: {name} is {shown(value)}; allowed: {', '.join(words)}")
    return word
