"""Size of a jaw from its motion alone: the mouthpiece turns about condyles that slide on the fossa, whatever forces do.

The height of a point s times as far from the condyles as the table's is known at every pose, so that one number fits
all rows, beside the fossa's two, the mouthpiece's seat and its pitch, each within what a scan leaves of it, and where
the axes of the readings begin.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from jawenv.anatomy.attachments import attachment
from jawenv.anatomy.description import Anatomy
from jawenv.anatomy.mandible import default_fossa, default_mandible
from jawenv.anatomy.muscles import PORTIONS, SIDES
from jawenv.recordings.defaults import BENCH
from jawenv.recordings.estimate import Array
from jawenv.recordings.files import load_record
from jawenv.recordings.record import Record
from jawenv.recordings.table import RecordTable

SMALLEST, LARGEST = 0.6, 1.5
UNTOLD, SURE_SDS = 0.02, 3.0
"""A size nearer to 1, or by fewer of its sds away, is that of the table."""
AXES_MM = 3.0  # sd of where the axes begin, which are laid through condyles that somebody felt for
MOST_SD = 0.02  # of a size; one that is less certain is none
STARTS = (0.8, 1.0, 1.2)
_HEIGHT_SD = 0.2e-3  # m, of errors that last
_FOSSA_SD, _SEAT_SD, _PITCH_SD = 0.1, 0.5e-3, np.radians(0.5)
_ROWS, _TELLING = 100, 30.0  # that are fitted; rows with errors of their own, as which all count
_FARTHEST = 3.0  # m or rad, beyond which no jaw is
_LEAST_PITCH = 0.05  # rad that the jaw turns by, or its size is not seen


def by_its_motion(table: RecordTable, record: Record, **reading: Any) -> Record | None:
    """The recording with axes that begin anywhere near the condyles, of a jaw of the size that its motion shows.

    None where file or caller says what is known. A jaw that was given keeps its size.

    Args:
        table: of the file.
        record: as read of a jaw of the table's size.
        **reading: arguments of ``load_record``.
    """
    said = {name for name, value in reading.items() if value is not None} | set(table.header)
    if "knowledge" in said:
        return None
    size, sd = (1.0, 0.0) if said & {"anatomy", "jaw"} else size_of(record)
    if size != 1.0 and sd <= MOST_SD:
        record = load_record(table, BENCH, **(reading | {"anatomy": sized(size)}))
    place = 1e3 * sd * float(np.linalg.norm(record.jaw["mouthpiece"])) if sd <= MOST_SD else 0.0
    known = replace(record.knowledge, axes_mm=AXES_MM, mouthpiece_mm=max(record.knowledge.mouthpiece_mm, place))
    return replace(record, knowledge=known)


def size_in(jaw: Any) -> float:
    """Size over the table's of a record's jaw that is the table's but for that; 1 for any other."""
    size = float(jaw["mouthpiece"][0] / default_mandible().mouthpiece_m[0])
    same = np.allclose(jaw["teeth"], size * default_mandible().teeth_m) and np.isclose(
        jaw["mass"], size**3 * default_mandible().mass_kg
    )
    return size if same else 1.0


def size_of(record: Record) -> tuple[float, float]:
    """Size over the table's of the jaw that moves so, and its sd; 1 where it hardly moves, or within ``UNTOLD``.

    Args:
        record: with places and angles of the mouthpiece.
    """
    pose = record.measured[np.isfinite(record.measured[:, :6]).all(axis=1), :6]
    if len(pose) < _ROWS or np.ptp(pose[:, 3]) < _LEAST_PITCH or np.abs(pose).max() > _FARTHEST:
        return 1.0, np.inf
    pose = pose[np.linspace(0, len(pose) - 1, _ROWS).astype(int)]
    weight = np.sqrt(_TELLING / len(pose)) / _HEIGHT_SD

    def residuals(guess: Array) -> Array:
        return np.append(weight * _height_error(pose[:, :3], pose[:, 3:], guess), guess[1:])

    low, high = np.array([SMALLEST, *[-4.0] * 7]), np.array([LARGEST, *[4.0] * 7])
    ways = (least_squares(residuals, [size, *[0.0] * 7], bounds=(low, high)) for size in STARTS)
    found = min(ways, key=lambda way: float(way.cost))
    size, sd = float(found.x[0]), float(np.linalg.pinv(found.jac.T @ found.jac)[0, 0] ** 0.5)
    return (1.0, sd) if abs(size - 1.0) < max(UNTOLD, SURE_SDS * sd) else (size, sd)


def _height_error(place: Array, angles: Array, guess: Array) -> Array:
    """(N,) m by which the condyles are above the fossa at the poses read, for size, fossa, seat and pitch."""
    size, depth, frequency, seat_x, seat_z, pitch, axes_x, axes_z = guess
    fossa, own = default_fossa(), default_mandible().mouthpiece_m
    shift = _SEAT_SD * np.array([seat_x, seat_z])  # the encoders are zeroed with the teeth together
    x, z = size * own[0] + shift[0], size * own[2] + shift[1]
    turned = Rotation.from_euler("YZX", angles + np.array([_PITCH_SD * pitch, 0.0, 0.0]))
    across, _, upward = turned.apply([x, 0.0, z]).T
    axes = 1e-3 * AXES_MM * np.array([axes_x, axes_z])
    along = place[:, 0] + axes[0] + shift[0] - across
    drop = size * fossa.drop_m * np.exp(_FOSSA_SD * depth)
    wave = fossa.spatial_frequency / size * np.exp(_FOSSA_SD * frequency)
    error: Array = place[:, 2] + axes[1] + shift[1] - upward - drop * (np.cos(wave * along) - 1.0)
    return error


def sized(size: float) -> Anatomy:
    """The table's anatomy at another size: lengths as ``size``, masses as its cube."""
    mandible, fossa = default_mandible(), default_fossa()
    lines = {}
    for portion in PORTIONS:
        for side in SIDES:
            line = attachment(portion, side)
            ends = size * line.origin_m, size * line.insertion_m
            lines[f"{portion}_{side}"] = replace(line, origin_m=ends[0], insertion_m=ends[1])
    body = replace(
        mandible,
        mass_kg=size**3 * mandible.mass_kg,
        inertia_kg_m2=size**5 * mandible.inertia_kg_m2,
        centre_of_mass_m=size * mandible.centre_of_mass_m,
        mouthpiece_m=size * mandible.mouthpiece_m,
        teeth_m=size * mandible.teeth_m,
        condyle_half_width_m=size * mandible.condyle_half_width_m,
    )
    path = replace(fossa, drop_m=size * fossa.drop_m, spatial_frequency=fossa.spatial_frequency / size)
    return Anatomy(lines, body, path)
