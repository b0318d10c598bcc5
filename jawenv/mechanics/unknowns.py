"""Numbers of a jaw that are known only within an sd: how one sd of each changes it, and a jaw drawn from all."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, pi, radians, sin
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy.knowledge import Knowledge
from jawenv.anatomy.muscles import MuscleSet
from jawenv.kernels.vec3 import apply, cross, norm, subtract
from jawenv.mechanics.kinematics import contact_point, rotation

# Poses (x in m, pitch in rad) at which the effects of attachments are compared; openings that comfort allows.
POSES = [(x, 0.0, pitch, yaw, 0.0) for x, pitch in ((2e-3, 0.04), (5e-3, 0.14), (8e-3, 0.24)) for yaw in (-0.04, 0.04)]
# N, rms over the poses: a shift of a line's ends that moves less than this is left out. The unmodelled force, 0.1 N per
# tick, hides a constant force of 0.002 N in 30 s.
NEGLIGIBLE = 2e-3

N_MOTORS, N_MOTOR_ERRORS = 4, 5
N_INERTIAL = 4
MASS, DAMPING = 2, slice(3, 5)
"""Which of ``Unknowns.numbers`` are the mass and both dampings."""
FARTHEST = 4.0  # sds that a nuisance may be from its nominal value, drawn or believed


class Unknowns(NamedTuple):
    """Values of all nuisances that are not exactly known, in sds, standard normal."""

    origin: NDArray[np.float64]  # (lines, 3) attachments
    insertion: NDArray[np.float64]  # (lines, 3)
    numbers: NDArray[np.float64]
    """(6,) drop and frequency of the fossa, mass, damping of rotation and sliding, head tilt."""
    centre_of_mass: NDArray[np.float64]  # (3,)
    mouthpiece: NDArray[np.float64]  # (3,)
    turn: NDArray[np.float64]  # (3,) of the mouthpiece about the body's axes
    offset: NDArray[np.float64]  # (6,) of the load cell
    inertia: NDArray[np.float64]
    """(1,) the whole tensor. The filter has no column for it: a tenth moves nothing that can be measured."""
    cell_turn: NDArray[np.float64]  # (3,) of the load cell's axes, beside ``turn``
    motors: NDArray[np.float64]
    """(4, ``N_MOTOR_ERRORS``) of a force that no load cell reads: each motor's gain, Coulomb and viscous friction,
    and direction about two axes (``device.force_sensor``).
    """
    tone: NDArray[np.float64]  # (1,) of the closers
    inertial: NDArray[np.float64]
    """(4,) mass and centre of mass once more, as accelerations show them: the same numbers, which a filter may take
    for others.
    """


def no_unknowns(lines: int) -> Unknowns:
    """All at their nominal values."""
    rest = (6, 3, 3, 3, 6, 1, 3, (N_MOTORS, N_MOTOR_ERRORS), 1, N_INERTIAL)
    return Unknowns(np.zeros((lines, 3)), np.zeros((lines, 3)), *(np.zeros(shape) for shape in rest))


def draw_unknowns(lines: int, generator: np.random.Generator) -> Unknowns:
    """Standard normals for all but motors and tone, none beyond ``FARTHEST``: a mass stays positive."""
    none = no_unknowns(lines)
    undrawn = none._replace(tone=np.empty(0), inertial=np.empty(0))
    drawn = Unknowns(*(_normals(values, generator) for values in undrawn))
    return with_inertial(drawn._replace(motors=none.motors, tone=none.tone))


def with_inertial(values: Unknowns) -> Unknowns:
    """The same with accelerations that show its mass and centre of mass."""
    return values._replace(inertial=np.append(values.numbers[MASS], values.centre_of_mass))


def as_body(values: Unknowns) -> Unknowns:
    """The same with what ``inertial`` has added to mass and centre of mass, and nothing left there."""
    numbers = values.numbers.copy()
    numbers[MASS] += values.inertial[0]
    centre = values.centre_of_mass + values.inertial[1:]
    return values._replace(numbers=numbers, centre_of_mass=centre, inertial=np.zeros(N_INERTIAL))


def with_motors(values: Unknowns, generator: np.random.Generator) -> Unknowns:
    """The same with standard normals for the motors, none beyond ``FARTHEST``."""
    return values._replace(motors=_normals(values.motors, generator))


def with_tone(values: Unknowns, generator: np.random.Generator) -> Unknowns:
    """The same with a standard normal for the tone, not beyond ``FARTHEST``."""
    return values._replace(tone=_normals(values.tone, generator))


def _normals(values: NDArray[np.float64], generator: np.random.Generator) -> NDArray[np.float64]:
    return np.clip(generator.standard_normal(values.shape), -FARTHEST, FARTHEST)


def along(values: Unknowns, direction: Unknowns) -> float:
    """How far values are along one of ``directions``, in sds."""
    return float(sum(np.vdot(value, way) for value, way in zip(values, direction, strict=True)))


def changed_jaw(jaw: Any, knowledge: Knowledge, muscles: MuscleSet, values: Unknowns) -> Any:
    """A copy of the record ``jaw`` with its numbers at ``values``, about those that it has."""
    changed = jaw.copy()
    drop, frequency, mass, rotation_damping, sliding_damping, tilt = values.numbers
    changed["fossa_drop"] *= 1.0 + knowledge.fossa * drop
    changed["fossa_frequency"] *= 1.0 + knowledge.fossa * frequency
    changed["crest"] = pi / changed["fossa_frequency"]
    changed["damping_rotation"] *= 1.0 + knowledge.damping * rotation_damping
    changed["damping_sliding"] *= 1.0 + knowledge.damping * sliding_damping
    changed["tone"] += knowledge.closing_tone_N * muscles.whole_muscles_per_line * values.tone[0]
    changed["gravity"] = _pitched(jaw["gravity"], radians(knowledge.head_tilt_deg) * tilt)
    for name in ("mouthpiece", "zero", "teeth"):
        changed[name] += 1e-3 * knowledge.mouthpiece_mm * values.mouthpiece
    if knowledge.attachments > 0.0:
        changed["origin"] += knowledge.attachments * muscles.origin_sd_m * values.origin
        changed["insertion"] += knowledge.attachments * muscles.insertion_sd_m * values.insertion
        changed["l_o"] = np.linalg.norm(changed["origin"] - changed["insertion"], axis=1)
    shift = 1e-3 * np.array(
        [knowledge.centre_of_mass_x_mm, knowledge.centre_of_mass_y_mm, knowledge.centre_of_mass_z_mm]
    )
    changed["mass"] *= 1.0 + knowledge.mass * mass
    changed["centre_of_mass"] += shift * values.centre_of_mass
    changed["inertia"] *= 1.0 + knowledge.inertia * values.inertia[0]
    _set_inverses(changed)
    return changed


def _pitched(gravity: NDArray[np.float64], tilt: float) -> NDArray[np.float64]:
    """Gravity in the axes of a head that is pitched down by so much more."""
    x, y, z = gravity
    return np.array([x * cos(tilt) - z * sin(tilt), y, z * cos(tilt) + x * sin(tilt)])


def _set_inverses(jaw: Any) -> None:
    """The inverses of a jaw's inertia about the contact point, for its free rotations."""
    rho, turns = jaw["centre_of_mass"], np.flatnonzero(np.diag(jaw["inertia_contact_inverse"]) > 0.0)
    about_contact = jaw["inertia"] + jaw["mass"] * (rho @ rho * np.eye(3) - np.outer(rho, rho))
    jaw["inertia_inverse"] = np.linalg.inv(jaw["inertia"])
    jaw["inertia_contact_inverse"][np.ix_(turns, turns)] = np.linalg.inv(about_contact[np.ix_(turns, turns)])


def turn_of(knowledge: Knowledge, values: Unknowns) -> NDArray[np.float64]:
    """(3,) rotation of the mouthpiece about the body's axes, rad."""
    return radians(knowledge.mouthpiece_deg) * values.turn


def cell_turn_of(knowledge: Knowledge, values: Unknowns) -> NDArray[np.float64]:
    """(3,) rotation of the load cell's axes, which is the mouthpiece's and its own, rad."""
    return turn_of(knowledge, values) + radians(knowledge.cell_deg) * values.cell_turn


def offset_of(knowledge: Knowledge, values: Unknowns) -> NDArray[np.float64]:
    """(6,) the load cell's offset, N and N m."""
    return np.repeat([knowledge.cell_offset_N, knowledge.cell_offset_N_m], 3) * values.offset


def directions(
    knowledge: Knowledge,
    muscles: MuscleSet,
    jaw: Any,
    log_parameters: NDArray[np.float64],
    motor_sds: NDArray[np.float64] | None = None,
    *,
    lasting: bool = False,
) -> list[Unknowns]:
    """One sd of every nuisance that moves the jaw by more than the noise hides.

    A line's six coordinates of ends are taken in the directions in which they act: those along the line have no effect,
    and are left out.

    Args:
        knowledge: the sds of anatomy, body and mounting.
        muscles: the jaw's.
        jaw: the filter's model.
        log_parameters: (p,) of a typical patient.
        motor_sds: (``N_MOTOR_ERRORS``,) those of each motor's force, or None where a load cell reads it.
        lasting: whether the disturbance has memory: then mass and centre of mass are there once more (``inertial``).
    """
    lines, vectors = len(muscles.muscle), []

    def one(name: str, *index: int) -> Unknowns:
        values = no_unknowns(lines)
        getattr(values, name)[index] = 1.0
        return values

    numbers = (
        knowledge.fossa,
        knowledge.fossa,
        knowledge.mass,
        knowledge.damping,
        knowledge.damping,
        knowledge.head_tilt_deg,
    )
    vectors += [one("numbers", k) for k, sd in enumerate(numbers) if sd > 0.0]
    if knowledge.closing_tone_N > 0.0:
        vectors.append(one("tone", 0))
    sds = (knowledge.centre_of_mass_x_mm, knowledge.centre_of_mass_y_mm, knowledge.centre_of_mass_z_mm)
    vectors += [one("centre_of_mass", k) for k, sd in enumerate(sds) if sd > 0.0]
    if lasting:
        vectors += [one("inertial", k) for k, sd in enumerate((knowledge.mass, *sds)) if sd > 0.0]
    vectors += [one("mouthpiece", k) for k in range(3) if knowledge.mouthpiece_mm > 0.0]
    vectors += [one("turn", k) for k in range(3) if knowledge.mouthpiece_deg > 0.0]
    cell = [knowledge.cell_offset_N] * 3 + [knowledge.cell_offset_N_m] * 3
    vectors += [one("offset", k) for k, sd in enumerate(cell) if sd > 0.0]
    vectors += [one("cell_turn", k) for k in range(3) if knowledge.cell_deg > 0.0]
    if knowledge.attachments > 0.0:
        for line in range(lines):
            vectors += list(_of_line(knowledge, muscles, jaw, log_parameters, line))
    if motor_sds is not None:
        vectors += [one("motors", i, k) for k in range(N_MOTOR_ERRORS) if motor_sds[k] > 0.0 for i in range(N_MOTORS)]
    return vectors


def _of_line(
    knowledge: Knowledge, muscles: MuscleSet, jaw: Any, log_parameters: NDArray[np.float64], line: int
) -> Iterator[Unknowns]:
    """The directions of a line's ends that act, by the singular values of what they do to its wrench."""
    lines, step = len(muscles.muscle), 1e-3
    first = 2 * muscles.muscle[line]
    law = np.exp(log_parameters[first : first + 2])
    effects = np.empty((6 * len(POSES), 6))
    for k in range(6):
        values = no_unknowns(lines)
        (values.origin if k < 3 else values.insertion)[line, k % 3] = step
        changed = changed_jaw(jaw, knowledge, muscles, values)
        effects[:, k] = (_pulls(changed, line, law) - _pulls(jaw, line, law)) / step
    _, sizes, turned = np.linalg.svd(effects)
    for size, direction in zip(sizes, turned, strict=True):
        if size > NEGLIGIBLE * np.sqrt(len(POSES)):
            values = no_unknowns(lines)
            values.origin[line], values.insertion[line] = direction[:3], direction[3:]
            yield values


def _pulls(jaw: Any, line: int, law: NDArray[np.float64]) -> NDArray[np.float64]:
    """(6 poses,) force (N) and moment over 5 cm (N) of a line at each of ``POSES``."""
    pulls = []
    for pose in POSES:
        turned, contact = rotation(pose), contact_point(jaw, pose)
        arm = apply(turned, tuple(jaw["insertion"][line]))
        way = subtract(tuple(jaw["origin"][line]), tuple(np.add(contact, arm)))
        length = norm(way)
        tension = jaw["tone"] + law[0] * np.exp(law[1] * (length / jaw["l_o"][line] - 1.0))
        pull = tuple(tension / length * np.array(way))
        pulls += [*pull, *(np.array(cross(arm, pull)) / 0.05)]
    return np.array(pulls)
