"""Draws of anatomy, mounting and load cell into a world's truth, with sds that the filter knows or lacks."""

from __future__ import annotations

from typing import Any

import numpy as np

from jawenv.anatomy.knowledge import Knowledge
from jawenv.anatomy.muscles import MuscleSet
from jawenv.filter.nuisances.unknowns import (
    Values,
    cell_turn_of,
    changed_jaw,
    draw_unknowns,
    no_unknowns,
    offset_of,
    turn_of,
    with_anatomy_of,
    with_motors,
)
from jawenv.kernels.noise import Streams
from jawenv.reality import Reality
from jawenv.reality.geometry import perturb_geometry


def draw_truth(
    truth: Any, knowledge: Knowledge, reality: Reality, muscles: MuscleSet, streams: Streams, anatomy_seed: int | None
) -> Values:
    """Draw anatomy, body, mounting and load cell of a world; returns the deviations whose sds the filter knows.

    Args:
        truth: Its record, dtype ``truth_dtype``, with the jaw at the filter's nominal values; changed in place.
        knowledge: The sds known to the filter.
        reality: Errors of the same quantities that are hidden from the filter.
        muscles: The cohort's.
        streams: Sources of the draws.
        anatomy_seed: Seed of a patient with the same anatomy in every episode, or None.
    """
    for name in ("cell_offset", "turn", "cell_turn"):
        truth[name] = 0.0
    lines, untold = len(muscles.muscle), reality.untold()
    values = no_unknowns(lines)
    if not knowledge.exact:
        values = draw_unknowns(lines, streams.geometry, knowledge)
        if anatomy_seed is not None:
            values = with_anatomy_of(draw_unknowns(lines, np.random.default_rng(anatomy_seed)), values)
        _add(truth, knowledge, muscles, values)
    perturb_geometry(reality, muscles, truth["jaw"], streams.geometry)
    if not untold.exact:
        _add(truth, untold, muscles, draw_unknowns(lines, streams.untold, untold))
    return with_motors(values, streams.motors)


def _add(truth: Any, knowledge: Knowledge, muscles: MuscleSet, values: Values) -> None:
    """Change a world's jaw, mounting and load cell by ``values``."""
    truth["jaw"] = changed_jaw(truth["jaw"], knowledge, muscles, values)
    truth["cell_offset"] += offset_of(knowledge, values)
    truth["turn"] += turn_of(knowledge, values)
    truth["cell_turn"] += cell_turn_of(knowledge, values)
