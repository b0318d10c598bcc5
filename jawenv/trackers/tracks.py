"""The content of a jaw tracker's file, and the parts that text formats share."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from jawenv.base.errors import InputError, printable, shown
from jawenv.recordings.dialects import number
from jawenv.recordings.mapping import UNITS, factor
from jawenv.recordings.table import RecordTable

Array = NDArray[np.float64]

SLOWEST, FASTEST = 1e-3, 1e6
"""Hz, of frames."""
LARGEST_MM = 1e9
"""Farthest place: no tracker sees beyond."""
LONGEST_LIST = 400
"""Characters of names in a message."""


@dataclass(frozen=True, eq=False)
class Tracks:
    """Points, bodies and wrenches over T times, in the axes of the file."""

    path: str  # of the file, for messages
    time: Array  # (T,) s
    places: dict[str, Array]
    """(T, 3) mm of each marker and each body's origin, by name; NaN where the tracker lost it. A marker at 0, 0, 0
    is a lost one, and so is a body there that is not turned.
    """
    rotations: dict[str, Array] = field(default_factory=dict)
    """(T, 3, 3) of each body, body axes to the file's; NaN likewise."""
    wrenches: dict[str, Array] = field(default_factory=dict)  # (T, 6) N and N m, by name
    points: dict[str, Array] = field(default_factory=dict)
    """(T, 3) mm where a wrench acts, by its name; without one it is about the mouthpiece."""
    axes: dict[str, Array] = field(default_factory=dict)
    """(3, 3) from the file's axes to forward, left and up, by the name of what is in them; none where the file is
    silent.
    """
    analog: RecordTable | None = None  # channels beside the points, on their clock

    def __post_init__(self) -> None:
        """Check times and rotations, and take lost markers out."""
        if len(self.time) < 2:
            raise InputError(f"{self.path}: holds {len(self.time)} rows; allowed: two or more")
        if not (np.diff(self.time) > 0.0).all():
            raise InputError(f"{self.path}: times do not grow, or one is missing; allowed: growing seconds")
        for name, place in self.places.items():
            if (np.abs(place) > LARGEST_MM).any():
                far = f"{float(np.nanmax(np.abs(place))):.3g} mm"
                raise InputError(f"{self.path}: {shown(name)} is {far} away; allowed: {LARGEST_MM:g} mm (the unit?)")
            lost = (place == 0.0).all(axis=1)
            if name in self.rotations:  # one that is given from its own beginning is there in the first row
                lost &= (self.rotations[name] == np.eye(3)).all(axis=(1, 2)) & ~lost[0]
            self.places[name] = np.where(lost[:, None], np.nan, place)
        for name, matrices in self.rotations.items():
            seen = matrices[np.isfinite(matrices).all(axis=(1, 2))]
            with np.errstate(over="ignore", invalid="ignore"):
                product = seen @ seen.transpose(0, 2, 1)
            if not (np.allclose(product, np.eye(3), atol=1e-3) and (np.linalg.det(seen) > 0.0).all()):
                raise InputError(f"{self.path}: rotations of {shown(name)} mirror or scale; allowed: proper rotations")

    def turned(self, name: str) -> Tracks:
        """Tracks turned to forward, left and up where the file states the axes of a point or body."""
        axes = self.axes.get(name, np.eye(3))
        return replace(
            self,
            places={one: place @ axes.T for one, place in self.places.items()},
            rotations={one: axes @ matrices @ axes.T for one, matrices in self.rotations.items()},
        )


def is_rate(value: object) -> bool:
    """Whether a file's word can be its frames per second."""
    return isinstance(value, int | float) and not isinstance(value, bool) and SLOWEST < value < FASTEST


def distinct(labels: Sequence[str]) -> list[str]:
    """Labels, with a number behind each that stands there several times."""
    times, met = Counter(labels), Counter[str]()
    told = []
    for label in labels:
        met[label] += 1
        told.append(label if times[label] == 1 else f"{label} ({met[label]})")
    return told


def matrices(quaternions: Array) -> Array:
    """(T, 3, 3) rotation matrices of quaternions (T, 4), w first; NaN where a quaternion is not finite or 0."""
    result = np.full((len(quaternions), 3, 3), np.nan)
    largest = np.abs(quaternions).max(axis=1, initial=0.0, keepdims=True)
    seen = np.isfinite(quaternions).all(axis=1) & (largest[:, 0] > 1e-100)
    unit = quaternions[seen] / largest[seen]  # squares of others may be too large or too small
    result[seen] = Rotation.from_quat(unit, scalar_first=True).as_matrix()
    return result


def listed(names: Iterable[str]) -> str:
    """Names for a message, as many as fit a line."""
    every = [printable(name) for name in names]
    text = ", ".join(every)
    return text if len(text) <= LONGEST_LIST else f"{text[:LONGEST_LIST]} ... ({len(every)} names)"


def millimetres(unit: str | None, path: str) -> float:
    """The factor from a unit of length to mm."""
    if not unit:
        raise InputError(f"{path}: states no unit of length; allowed: --unit {', '.join(UNITS['mm'])}")
    return factor("position_mm", unit, path)


def numbers(path: str, lines: Sequence[tuple[int, str]], names: Sequence[str], separator: str | None) -> Array:
    """The rows of a text table, NaN for an empty cell.

    Args:
        path: of the file, for messages.
        lines: number and text of each row.
        names: of the columns.
        separator: between cells; None for any blanks.
    """
    rows = []
    for line, text in lines:
        cells = [cell.strip() for cell in text.split(separator)]
        while len(cells) > len(names) and not cells[-1]:
            cells.pop()
        if len(cells) != len(names):
            raise InputError(f"{path}: row {line} has {len(cells)} values; allowed: {len(names)}, one per column")
        values = [number(cell) for cell in cells]
        if None in values:
            bad = values.index(None)
            raise InputError(f"{path}: {names[bad]} in row {line} is {shown(cells[bad])}; allowed: a number")
        rows.append(values)
    return np.array(rows, dtype=np.float64).reshape(len(rows), len(names))


def check_rows(path: str, rows: int, stated: str | None, field_name: str) -> None:
    """Check that a file holds as many rows as its header states, if it does."""
    if stated is not None and stated.strip() != str(rows):
        raise InputError(f"{path}: holds {rows} rows; allowed: {shown(stated)}, its {field_name} (a truncated file?)")
