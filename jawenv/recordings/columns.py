"""The columns of a recording's file: name with unit, and which number of a ``Record`` it holds in which scale.

Head axes: x forward, y left, z up, from midway between the condyles' centres with the jaw closed. Body axes: the same
axes carried along by the mandible. Pitch (theta) is positive when the jaw opens, yaw (psi) to the left, roll (alpha).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees

TIME = "time_s"
OPENING, FORCE = "opening_mm", "force_N"
"""Columns of a stretcher's log."""
AXES = ("x", "y", "z")
ANGLES = ("pitch", "yaw", "roll")
TICK_MOMENTS = ("start", "middle", "end")
MM = 1e3
DEG = degrees(1.0)


@dataclass(frozen=True)
class Column:
    """One column."""

    name: str  # as in the file's first row
    field: str  # the array of the record that it belongs to
    index: tuple[int, ...]  # place in a row of that array
    scale: float  # number in the file per SI unit
    what: str  # one line for people


def _encoders() -> list[Column]:
    columns = []
    for i, axis in enumerate(AXES):
        columns.append(Column(f"mouthpiece_{axis}_mm", "measured", (i,), MM, "place of the mouthpiece, head axes"))
    for i, angle in enumerate(ANGLES):
        columns.append(Column(f"{angle}_deg", "measured", (3 + i,), DEG, f"{angle} of the mouthpiece"))
    for i, axis in enumerate(AXES):
        name = f"velocity_{axis}_mm_s"
        columns.append(Column(name, "measured", (6 + i,), MM, "velocity of the mouthpiece, head axes"))
    for i, axis in enumerate(AXES):
        name = f"angular_velocity_{axis}_deg_s"
        columns.append(Column(name, "measured", (9 + i,), DEG, "angular velocity, body axes"))
    return columns


def _wrench(prefix: str, field: str, moment: int | None) -> list[Column]:
    """Force and moment at one moment of a tick, or at the row's time where ``moment`` is None."""
    suffix = "" if moment is None else f"_{TICK_MOMENTS[moment]}"
    description = "at the row's time" if moment is None else f"{TICK_MOMENTS[moment]} of the tick that begins there"
    index = () if moment is None else (moment,)
    columns = []
    for i, axis in enumerate(AXES):
        name = f"{prefix}force_{axis}{suffix}_N"
        columns.append(Column(name, field, (*index, i), 1.0, f"force on the mouthpiece, body axes, {description}"))
    for i, axis in enumerate(AXES):
        name = f"{prefix}moment_{axis}{suffix}_N_m"
        columns.append(Column(name, field, (*index, 3 + i), 1.0, f"moment at the mouthpiece, body axes, {description}"))
    return columns


def _true_motion() -> list[Column]:
    names = [(f"true_condyle_{axis}_mm", MM) for axis in AXES[:2]]
    names += [(f"true_{angle}_deg", DEG) for angle in ANGLES]
    names += [(f"true_condyle_velocity_{axis}_mm_s", MM) for axis in AXES[:2]]
    names += [(f"true_angular_velocity_{axis}_deg_s", DEG) for axis in AXES]
    description = "true motion of a simulated jaw"
    return [Column(name, "states", (i,), scale, description) for i, (name, scale) in enumerate(names)]


ENCODERS = tuple(_encoders())
READINGS = tuple(_wrench("", "reading", None))
"""One load-cell reading per row, as most benches have it."""
SAMPLES = tuple(column for moment in range(3) for column in _wrench("", "samples", moment))
"""Three load-cell readings per tick, as the simulated device has them."""
TRUE_MOTION = tuple(_true_motion())
TRUE_WRENCH = tuple(column for moment in range(3) for column in _wrench("true_", "wrenches", moment))
