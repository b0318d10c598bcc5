"""The content of a jaw tracker's file, and the parts that text formats share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from jawenv.errors import InputError, shown
from jawenv.laboratory.recordings.dialects import number
from jawenv.laboratory.recordings.mapping import UNITS, factor

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Tracks:
    """Points, bodies and wrenches over T times, in the axes of the file.

    Attributes:
        path: of the file, for messages.
        time: (T,) s.
        places: (T, 3) mm of each marker and each body's origin, by name; NaN where the tracker lost it.
        rotations: (T, 3, 3) of each body, body axes to the file's; NaN likewise.
        wrenches: (T, 6) N and N m, by name.
        axes: (3, 3) from the file's axes to forward, left and up; None where the file is silent.
    """

    path: str
    time: Array
    places: dict[str, Array]
    rotations: dict[str, Array] = field(default_factory=dict)
    wrenches: dict[str, Array] = field(default_factory=dict)
    axes: Array | None = None

    def __post_init__(self) -> None:
        """Check that there are times and that rotations are rotations.

        Raises:
            InputError: fewer than two rows, or a matrix that mirrors or scales.
        """
        if len(self.time) < 2:
            raise InputError(f"{self.path}: holds {len(self.time)} rows; allowed: two or more")
        for name, matrices in self.rotations.items():
            seen = matrices[np.isfinite(matrices).all(axis=(1, 2))]
            product = seen @ seen.transpose(0, 2, 1)
            if not (np.allclose(product, np.eye(3), atol=1e-3) and (np.linalg.det(seen) > 0.0).all()):
                raise InputError(f"{self.path}: rotations of {shown(name)} mirror or scale; allowed: proper rotations")


def millimetres(unit: str | None, path: str) -> float:
    """The factor from a unit of length to mm.

    Raises:
        InputError: no unit, or an unknown one.
    """
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

    Raises:
        InputError: a row with more or fewer cells than names, or a cell without a number.
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


def whole(path: str, rows: int, stated: object, field_name: str) -> None:
    """Check that a file holds as many rows as its header states.

    Raises:
        InputError: it does not.
    """
    if str(stated) != str(rows):
        raise InputError(f"{path}: holds {rows} rows; allowed: {shown(stated)}, its {field_name} (a truncated file?)")
