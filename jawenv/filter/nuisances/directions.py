"""The nuisances of a filter: one sd of every unknown that moves the jaw by more than the noise hides."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from jawenv.anatomy.cohorts import cohort
from jawenv.anatomy.knowledge import Knowledge
from jawenv.anatomy.muscles import MuscleSet
from jawenv.device.device import N_MOTORS
from jawenv.device.force_sensor import N_SDS
from jawenv.filter.belief.state import tension_columns
from jawenv.filter.model.basis import N_NODES
from jawenv.filter.nuisances.unknowns import AGAIN, BY_NAME, MOTORS, UNKNOWNS, Array, Values, changed_jaw, no_unknowns
from jawenv.kernels.vec3 import apply, cross, norm, subtract
from jawenv.mechanics.kinematics import contact_point, rotation

# Poses (x in m, pitch in rad) at which the effects of attachments are compared; openings that comfort allows.
POSES = [(x, 0.0, pitch, yaw, 0.0) for x, pitch in ((2e-3, 0.04), (5e-3, 0.14), (8e-3, 0.24)) for yaw in (-0.04, 0.04)]
# N, rms over the poses: a shift of a line's ends that moves less than this is left out. The unmodelled force, 0.1 N per
# tick, hides a constant force of 0.002 N in 30 s.
NEGLIGIBLE = 2e-3


def directions(
    knowledge: Knowledge,
    muscles: MuscleSet,
    jaw: Any,
    log_parameters: Array,
    motor_sds: Array | None = None,
    *,
    with_memory: bool = False,
) -> list[Values]:
    """One sd of every nuisance.

    A line's six coordinates of ends are taken in the directions in which they act: those along the line have no effect,
    and are left out. Zeros at the end fill the columns that loops take at once: few kinds of kernels are compiled.

    Args:
        knowledge: the sds of anatomy, body and mounting.
        muscles: the jaw's.
        jaw: the filter's model.
        log_parameters: (p,) of a typical patient, who is one of ``anyone`` where a wrench is unknown.
        motor_sds: (5,) those of each motor's force, or None where a load cell reads it.
        with_memory: whether the disturbance has memory: then mass and centre of mass are there once more (``AGAIN``).
    """
    lines, found = len(muscles.muscle), list[Values]()
    if knowledge.wrench_N > 0.0:  # of a recording: any cohort's prior may be tried, by the same compiled filter
        log_parameters = cohort("anyone", muscles).typical

    def one(name: str, *index: int) -> Values:
        values = no_unknowns(lines)
        values[name][index] = 1.0
        return values

    for unknown in UNKNOWNS:
        if unknown.estimated:
            found += [one(unknown.name, k) for k, sd in enumerate(unknown.sds(knowledge)) if sd > 0.0]
        if with_memory and unknown.name == "centre_of_mass":
            sds = [*BY_NAME["mass"].sds(knowledge), *unknown.sds(knowledge)]
            found += [one(AGAIN, k) for k, sd in enumerate(sds) if sd > 0.0]
    if knowledge.attachments > 0.0:
        for line in range(lines):
            found += list(_of_line(knowledge, muscles, jaw, log_parameters, line))
    if motor_sds is not None:
        found += [one(MOTORS, i, k) for k in range(N_SDS) if motor_sds[k] > 0.0 for i in range(N_MOTORS)]
    spare = tension_columns(len(muscles), len(found)) - len(muscles) * N_NODES - 1 - len(found) if found else 0
    return found + [no_unknowns(lines)] * spare


def _of_line(knowledge: Knowledge, muscles: MuscleSet, jaw: Any, log_parameters: Array, line: int) -> Iterator[Values]:
    """The directions of a line's ends that act, by the singular values of what they do to its wrench."""
    lines, step = len(muscles.muscle), 1e-3
    first = 2 * muscles.muscle[line]
    law = np.exp(log_parameters[first : first + 2])
    effects = np.empty((6 * len(POSES), 6))
    for k in range(6):
        values = no_unknowns(lines)
        values["origin" if k < 3 else "insertion"][line, k % 3] = step
        changed = changed_jaw(jaw, knowledge, muscles, values)
        effects[:, k] = (_pulls(changed, line, law) - _pulls(jaw, line, law)) / step
    _, sizes, turned = np.linalg.svd(effects)
    for size, direction in zip(sizes, turned, strict=True):
        if size > NEGLIGIBLE * np.sqrt(len(POSES)):
            values = no_unknowns(lines)
            values["origin"][line], values["insertion"][line] = direction[:3], direction[3:]
            yield values


def _pulls(jaw: Any, line: int, law: Array) -> Array:
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
