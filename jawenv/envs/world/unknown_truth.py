"""What the filter does not know exactly of a world, drawn into its truth: within sds that it is told, and untold."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy.knowledge import Knowledge
from jawenv.anatomy.muscles import MuscleSet
from jawenv.envs.world.own_anatomy import with_anatomy_of
from jawenv.mechanics.unknowns import (
    Unknowns,
    cell_turn_of,
    changed_jaw,
    draw_unknowns,
    no_unknowns,
    offset_of,
    turn_of,
    with_motors,
)
from jawenv.reality import Reality, perturb_geometry


class Streams(NamedTuple):
    """Random numbers of an episode's beginning: what one draws moves no other, so that comparisons are paired."""

    patient: np.random.Generator
    geometry: np.random.Generator
    untold: np.random.Generator
    motors: np.random.Generator

    @classmethod
    def of(cls, key: NDArray[np.uint64]) -> Streams:
        """Those of an episode; streams of different numbers share none."""
        counters = [np.array([0, 0, 0, number], dtype=np.uint64) for number in range(4)]
        return cls(*(np.random.Generator(np.random.Philox(key=key, counter=counter)) for counter in counters))


def draw_truth(
    truth: Any, knowledge: Knowledge, reality: Reality, muscles: MuscleSet, streams: Streams, anatomy_seed: int | None
) -> Unknowns:
    """Draw anatomy, body, mounting and load cell of a world; returns what was drawn of that which the filter is told.

    Args:
        truth: Its record, dtype ``truth_dtype``, with the jaw at the filter's nominal values; changed in place.
        knowledge: Sds that the filter is told.
        reality: Of which it is not.
        muscles: The cohort's.
        streams: Sources of the draws.
        anatomy_seed: Of a patient whose own values are the same in every episode, or None.
    """
    for name in ("cell_offset", "turn", "cell_turn"):
        truth[name] = 0.0
    lines, untold = len(muscles.muscle), reality.untold()
    values = no_unknowns(lines)
    if not knowledge.exact:
        values = draw_unknowns(lines, streams.geometry)
        if anatomy_seed is not None:
            values = with_anatomy_of(draw_unknowns(lines, np.random.default_rng(anatomy_seed)), values)
        _add(truth, knowledge, muscles, values)
    perturb_geometry(reality, muscles, truth["jaw"], streams.geometry)
    if not untold.exact:
        _add(truth, untold, muscles, draw_unknowns(lines, streams.untold))
    return with_motors(values, streams.motors)


def _add(truth: Any, known: Knowledge, muscles: MuscleSet, values: Unknowns) -> None:
    """Change a world's jaw, mounting and load cell by ``values``."""
    truth["jaw"] = changed_jaw(truth["jaw"], known, muscles, values)
    truth["cell_offset"] += offset_of(known, values)
    truth["turn"] += turn_of(known, values)
    truth["cell_turn"] += cell_turn_of(known, values)
