"""The nuisances as the filter's kernels read them: what one sd of each changes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy import MuscleSet
from jawenv.anatomy.knowledge import Knowledge
from jawenv.device.force_sensor import motor_errors
from jawenv.filter.nuisances.changes import STEP
from jawenv.filter.nuisances.unknowns import (
    AGAIN,
    ATTACHMENTS,
    MOTORS,
    UNKNOWNS,
    Values,
    as_body,
    cell_turn_of,
    changed_jaw,
    offset_of,
    scaled,
    turn_of,
)

_PLAIN = ("mass", "gravity", "tone", "fossa_drop", "fossa_frequency", "damping_rotation", "damping_sliding")
_IN_MOTION = (*_PLAIN, "mouthpiece", "first_moment", "inertia")
_IN_MOTION_ALONE = tuple(unknown.name for unknown in UNKNOWNS if not unknown.at_rest)
_SEEN_BY_ENCODERS = ("fossa_drop", "fossa_frequency", "mouthpiece", "zero", "turn")


def write_nuisances(
    record: Any,
    jaw: Any,
    knowledge: Knowledge,
    muscles: MuscleSet,
    sds: list[Values],
    force: tuple[NDArray[np.float64], Any] | None = None,
) -> None:
    """Fill a record of dtype ``nuisance_dtype`` with the changes per sd, taken over ``STEP`` sds.

    Args:
        record: written.
        jaw: the filter's model.
        knowledge: the sds.
        muscles: the jaw's.
        sds: one sd of each nuisance, as ``directions`` gives them.
        force: sds of the errors of a force that no load cell reads, and the device's record; None where one does.
    """
    if force is not None:
        record["linkage"]["point"], record["linkage"]["direction"] = force[1]["point"], force[1]["direction"]
    for j, direction in enumerate(sds):
        record["again"][j], values = np.any(direction[AGAIN] != 0.0), as_body(direction)
        changed = changed_jaw(jaw, knowledge, muscles, scaled(values, STEP))
        for name in (*_PLAIN, "mouthpiece", "zero", "l_o"):
            record[name][j] = (changed[name] - jaw[name]) / STEP
        for name in ("origin", "insertion"):
            record[name][j] = ((changed[name] - jaw[name]) / STEP).ravel()
        first_moments = [body["mass"] * body["centre_of_mass"] for body in (changed, jaw)]
        record["first_moment"][j] = (first_moments[0] - first_moments[1]) / STEP
        record["inertia"][j] = ((_about_contact(changed) - _about_contact(jaw)) / STEP).ravel()
        record["offset"][j], record["turn"][j] = offset_of(knowledge, values), turn_of(knowledge, values)
        record["cell_turn"][j] = cell_turn_of(knowledge, values)
        ends = np.hstack([values[name] for name in ATTACHMENTS])
        record["line"][j] = np.flatnonzero(ends.any(axis=1))[0] if ends.any() else -1
        record["moves"][j] = any(np.any(record[name][j] != 0.0) for name in _IN_MOTION)
        shown = any(np.any(value != 0.0) for name, value in values.items() if name not in _IN_MOTION_ALONE)
        record["at_rest"][j] = shown and not record["again"][j]
        record["in_cell"][j] = np.any(record["offset"][j] != 0.0) or np.any(record["cell_turn"][j] != 0.0)
        record["turns"][j] = np.any(record["turn"][j] != 0.0)
        if force is not None and np.any(values[MOTORS] != 0.0):
            record["motor_errors"][j] = motor_errors(force[0], values[MOTORS], force[1])
            record["of_motors"][j] = True
        record["reads"][j] = any(np.any(record[name][j] != 0.0) for name in _SEEN_BY_ENCODERS)


def _about_contact(jaw: Any) -> NDArray[np.float64]:
    """(3, 3) inertia about the contact point."""
    rho = jaw["centre_of_mass"]
    inertia: NDArray[np.float64] = jaw["inertia"] + jaw["mass"] * (rho @ rho * np.eye(3) - np.outer(rho, rho))
    return inertia
