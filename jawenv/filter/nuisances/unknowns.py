"""Numbers of a patient and of the device that are known only within sds: one object each, and values of all.

A new one is a field of ``Knowledge`` and an entry of ``UNKNOWNS``. Truth and filter read both. A patient who comes
again has the same attachments, fossa, mass, centre of mass, inertia and damping (``own``). Tilt of the head, place and
turn of the mouthpiece, offset and axes of the load cell are others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, pi, radians, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy.knowledge import Knowledge
from jawenv.anatomy.muscles import MuscleSet
from jawenv.device.device import N_MOTORS
from jawenv.device.force_sensor import N_SDS
from jawenv.filter.belief.state import FARTHEST, N_OFFSETS, N_SHAPES
from jawenv.mechanics.dynamics import N_WRENCH

Array = NDArray[np.float64]
Values = dict[str, Array]
"""Deviations of all unknowns from their nominal values by name, in sds: standard normal."""
Change = Callable[[Any, Array, MuscleSet], None]

TURN, OFFSET, CELL_TURN, WRENCH = "turn", "offset", "cell_turn", "wrench"
"""Changes of what is read: angles of the mouthpiece, offset of the load cell, angles of its axes, what it misses."""
WRENCH_UNITS = {0: 1.0, 1: 1.0, 2: 1.0, 3: 0.03, 5: 0.03}
"""Components of a wrench that no muscle pulls, and how much of each is 1 N: a moment about the jaw's axis, which is
left out, acts as a force upwards does."""


@dataclass(frozen=True)
class Unknown:
    """Numbers that are known only within sds."""

    name: str
    group: str  # in tables
    sds: Callable[
        [Knowledge], Sequence[float] | Array
    ]  # of each number, in the unit of what it changes; 0: known exactly
    change: Change | None = None  # adds deviations to a jaw's record; None for what changes readings alone
    own: bool = False  # whether it is the patient's, the same in each session
    at_rest: bool = True  # whether a jaw at rest shows it
    estimated: bool = True  # whether the filter has columns of it
    late: bool = False  # whether it is drawn after the others, and only where it is unknown: it moves no other's draws


def _change_fossa(jaw: Any, shares: Array, muscles: MuscleSet) -> None:
    jaw["fossa_drop"] *= 1.0 + shares[0]
    jaw["fossa_frequency"] *= 1.0 + shares[1]
    jaw["crest"] = pi / jaw["fossa_frequency"]


def _change_mass(jaw: Any, shares: Array, muscles: MuscleSet) -> None:
    jaw["mass"] *= 1.0 + shares[0]


def _change_damping(jaw: Any, shares: Array, muscles: MuscleSet) -> None:
    jaw["damping_rotation"] *= 1.0 + shares[0]
    jaw["damping_sliding"] *= 1.0 + shares[1]


def _pitch_head(jaw: Any, tilt: Array, muscles: MuscleSet) -> None:
    """Gravity in the axes of a head that is pitched down by so much more."""
    (x, y, z), angle = jaw["gravity"], tilt[0]
    jaw["gravity"] = np.array([x * cos(angle) - z * sin(angle), y, z * cos(angle) + x * sin(angle)])


def _change_tone(jaw: Any, tone: Array, muscles: MuscleSet) -> None:
    jaw["tone"] += tone[0] * muscles.whole_muscles_per_line


def _move_centre_of_mass(jaw: Any, shift: Array, muscles: MuscleSet) -> None:
    jaw["centre_of_mass"] += shift


def _move_mouthpiece(jaw: Any, shift: Array, muscles: MuscleSet) -> None:
    """The encoders are zeroed with the teeth together, wherever the mouthpiece sits."""
    for name in ("mouthpiece", "zero", "teeth"):
        jaw[name] += shift


def _move_axes(jaw: Any, shift: Array, muscles: MuscleSet) -> None:
    jaw["zero"] += shift


def _change_inertia(jaw: Any, shares: Array, muscles: MuscleSet) -> None:
    jaw["inertia"] *= 1.0 + shares[0]


def _centre_of_mass_sds(sds: Knowledge) -> Array:
    return 1e-3 * np.array([sds.centre_of_mass_x_mm, sds.centre_of_mass_y_mm, sds.centre_of_mass_z_mm])


UNKNOWNS = (
    Unknown("fossa", "fossa", lambda sds: [sds.fossa] * 2, _change_fossa, own=True),
    Unknown("mass", "mass", lambda sds: [sds.mass], _change_mass, own=True),
    Unknown("damping", "damping", lambda sds: [sds.damping] * 2, _change_damping, own=True, at_rest=False),
    Unknown("head_tilt", "head tilt", lambda sds: [radians(sds.head_tilt_deg)], _pitch_head),
    Unknown("tone", "tone", lambda sds: [sds.closing_tone_N], _change_tone, late=True),
    Unknown("centre_of_mass", "centre of mass", _centre_of_mass_sds, _move_centre_of_mass, own=True),
    Unknown("mouthpiece", "mouthpiece, place", lambda sds: [1e-3 * sds.mouthpiece_mm] * 3, _move_mouthpiece),
    Unknown("axes", "encoders' axes", lambda sds: [1e-3 * sds.axes_mm] * 3, _move_axes, late=True),
    Unknown(TURN, "mouthpiece, angles", lambda sds: [radians(sds.mouthpiece_deg)] * 3),
    Unknown(OFFSET, "cell offset", lambda sds: [sds.cell_offset_N] * 3 + [sds.cell_offset_N_m] * 3),
    # The whole tensor: a tenth moves nothing that can be measured.
    Unknown("inertia", "inertia tensor", lambda sds: [sds.inertia], _change_inertia, own=True, estimated=False),
    Unknown(CELL_TURN, "cell, angles", lambda sds: [radians(sds.cell_deg)] * 3),
    Unknown(WRENCH, "wrench of no muscle", lambda sds: [sds.wrench_N] * N_SHAPES * len(WRENCH_UNITS), late=True),
)
"""In the order of the filter's columns, and of the draws."""
BY_NAME = {unknown.name: unknown for unknown in UNKNOWNS}
ATTACHMENTS = ("origin", "insertion")
"""Attachments, (lines, 3) each; their sds differ by muscle."""
MOTORS = "motors"
"""(4, 5) of a force that no load cell reads: each motor's gain, frictions and direction (``device.force_sensor``)."""
AGAIN = "inertial"
"""(4,) mass and centre of mass once more, as accelerations show them: a filter may take these for others."""
OWN = (*ATTACHMENTS, *(unknown.name for unknown in UNKNOWNS if unknown.own))
"""The patient's own; the others are a session's."""
_NOTHING = Knowledge()
_SIZES = {unknown.name: len(unknown.sds(_NOTHING)) for unknown in UNKNOWNS}


def no_unknowns(lines: int) -> Values:
    """All at their nominal values."""
    shapes: dict[str, Any] = dict.fromkeys(ATTACHMENTS, (lines, 3)) | _SIZES | {MOTORS: (N_MOTORS, N_SDS), AGAIN: 4}
    return {name: np.zeros(shape) for name, shape in shapes.items()}


def draw_unknowns(lines: int, generator: np.random.Generator, knowledge: Knowledge = _NOTHING) -> Values:
    """Standard normals for all but the motors, none beyond ``FARTHEST``: a mass stays positive."""
    values = no_unknowns(lines)
    early = [name for name in (*ATTACHMENTS, *BY_NAME) if name in ATTACHMENTS or not BY_NAME[name].late]
    late = [unknown.name for unknown in UNKNOWNS if unknown.late and any(unknown.sds(knowledge))]
    for name in early:
        values[name] = _normals(values[name], generator)
    generator.standard_normal(values[MOTORS].shape)  # as before the motors had a stream of their own: patients stay
    for name in late:
        values[name] = _normals(values[name], generator)
    return _with_inertial(values)


def _with_inertial(values: Values) -> Values:
    """The same with accelerations that show its mass and centre of mass."""
    return values | {AGAIN: np.append(values["mass"], values["centre_of_mass"])}


def as_body(values: Values) -> Values:
    """The same with what ``AGAIN`` has added to mass and centre of mass, and nothing left there."""
    again = values[AGAIN]
    mass, centre = values["mass"] + again[:1], values["centre_of_mass"] + again[1:]
    return values | {"mass": mass, "centre_of_mass": centre, AGAIN: np.zeros(4)}


def with_motors(values: Values, generator: np.random.Generator) -> Values:
    """The same with standard normals for the motors, none beyond ``FARTHEST``."""
    return values | {MOTORS: _normals(values[MOTORS], generator)}


def scaled(values: Values, share: float) -> Values:
    """So many times the values."""
    return {name: share * value for name, value in values.items()}


def _normals(values: Array, generator: np.random.Generator) -> Array:
    return np.clip(generator.standard_normal(values.shape), -FARTHEST, FARTHEST)


def along(values: Values, direction: Values) -> float:
    """Distance of values along one of ``directions``, in sds."""
    return float(sum(np.vdot(value, direction[name]) for name, value in values.items()))


def changed_jaw(jaw: Any, knowledge: Knowledge, muscles: MuscleSet, values: Values) -> Any:
    """A copy of the record ``jaw`` with its numbers moved by ``values``, in sds of ``knowledge``."""
    changed = jaw.copy()
    for unknown in UNKNOWNS:
        if unknown.change is not None:
            unknown.change(changed, np.asarray(unknown.sds(knowledge)) * values[unknown.name], muscles)
    if knowledge.attachments > 0.0:
        changed["origin"] += knowledge.attachments * muscles.origin_sd_m * values["origin"]
        changed["insertion"] += knowledge.attachments * muscles.insertion_sd_m * values["insertion"]
        changed["l_o"] = np.linalg.norm(changed["origin"] - changed["insertion"], axis=1)
    _set_inverses(changed)
    return changed


def _set_inverses(jaw: Any) -> None:
    """The inverses of a jaw's inertia about the contact point, for its free rotations."""
    rho, turns = jaw["centre_of_mass"], np.flatnonzero(np.diag(jaw["inertia_contact_inverse"]) > 0.0)
    about_contact = jaw["inertia"] + jaw["mass"] * (rho @ rho * np.eye(3) - np.outer(rho, rho))
    jaw["inertia_contact_inverse"][np.ix_(turns, turns)] = np.linalg.inv(about_contact[np.ix_(turns, turns)])


def _read(name: str, knowledge: Knowledge, values: Values) -> Array:
    return np.asarray(BY_NAME[name].sds(knowledge)) * values[name]


def turn_of(knowledge: Knowledge, values: Values) -> Array:
    """(3,) rotation of the mouthpiece about the body's axes, rad."""
    return _read(TURN, knowledge, values)


def cell_turn_of(knowledge: Knowledge, values: Values) -> Array:
    """(3,) rotation of the load cell's axes, which is the mouthpiece's and its own, rad."""
    return turn_of(knowledge, values) + _read(CELL_TURN, knowledge, values)


def offset_of(knowledge: Knowledge, values: Values) -> Array:
    """(36,) the load cell's offset, N and N m, by shapes of the pose: its own less the wrench of no muscle."""
    offset = np.zeros((N_SHAPES, N_WRENCH))
    offset[0] = _read(OFFSET, knowledge, values)
    units = np.array(list(WRENCH_UNITS.values()))
    offset[:, list(WRENCH_UNITS)] -= _read(WRENCH, knowledge, values).reshape(N_SHAPES, len(units)) * units
    return offset.reshape(N_OFFSETS)


def with_anatomy_of(patient: Values, session: Values) -> Values:
    """The patient's own values of one, and the session's of another."""
    return _with_inertial(session | {name: patient[name] for name in OWN})


def own_values(values: Values) -> NDArray[np.float64]:
    """(8 + 6 lines,) the patient's own values that the filter is told of, in prior sds; ends of each line last."""
    estimated = [values[unknown.name] for unknown in UNKNOWNS if unknown.own and unknown.estimated]
    return np.concatenate([*estimated, np.hstack([values[name] for name in ATTACHMENTS]).ravel()])
