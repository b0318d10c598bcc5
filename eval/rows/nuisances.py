"""The filter's belief on nuisances, unknowns beside the muscles, against their true values: by groups."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from jawenv.analysis.joint_likelihood import belief_of_nuisances
from jawenv.filter.nuisances.unknowns import AGAIN, ATTACHMENTS, MOTORS, UNKNOWNS, Values

_OF_NAME = (
    dict.fromkeys(ATTACHMENTS, "attachments")
    | {unknown.name: unknown.group for unknown in UNKNOWNS if unknown.estimated}
    | {MOTORS: "force of each motor", AGAIN: "inertia"}
)
GROUPS = (
    "attachments",
    "fossa",
    "mass",
    "centre of mass",
    "head tilt",
    "mouthpiece, place",
    "mouthpiece, angles",
    "cell offset",
    "cell, angles",
    "force of each motor",
    "tone",
    "inertia",
    "damping",
    "wrench of no muscle",
)
"""Groups of nuisances, in the order of tables."""
ERROR, LEFT = "nuisance_z2", "nuisance_left"
"""Columns of a group, ``<one of these>/<group>``: mean of (error / sd) squared, and of the sd in prior sds."""


def _group_of(direction: Values) -> str:
    """The group of one of the filter's nuisances; none of zeros."""
    return next((group for name, group in _OF_NAME.items() if np.any(direction[name])), "")


class NuisanceBeliefs:
    """Recorder of the filter's belief on nuisances at some times, for all worlds of ``jawenv.play`` (``on_step``).

    Args:
        times: s.
    """

    def __init__(self, times: Sequence[float]) -> None:
        """Nothing is heard yet."""
        self._times, self._step = tuple(times), 0
        self._kept: dict[float, list[dict[str, float]]] = {}

    def __call__(self, env: Any, action: Any) -> None:
        """Keep the beliefs where the time is one of those asked for."""
        simulation = env.unwrapped.simulation
        rate = simulation.configuration.steps_per_s
        for time in self._times:
            if round(time * rate) == self._step:
                self._kept[time] = [_figures_of(simulation, world) for world in range(len(simulation.worlds))]
        self._step += 1

    def added_to(self, rows: pd.DataFrame, first_seed: int) -> pd.DataFrame:
        """Rows of ``beliefs.rows_of`` with the columns of all groups; after the episodes."""
        worlds = rows["seed"] - first_seed
        judged = rows["nees"].notna()
        chosen = [
            self._kept[time][world] if is_judged else {}
            for world, time, is_judged in zip(worlds, rows["time_s"], judged, strict=True)
        ]
        return rows.join(pd.DataFrame(chosen, index=rows.index))


def _figures_of(simulation: Any, world: int) -> dict[str, float]:
    """Mean of (error / sd) squared of each group, and of its sds as shares of the prior's."""
    mean, sd = belief_of_nuisances(simulation, world)
    squares: NDArray[np.float64] = np.square((mean - simulation.worlds["truth"]["nuisances"][world]) / sd)
    groups = np.array([_group_of(direction) for direction in simulation.nuisance_sds])
    figures: dict[str, float] = {}
    for group in filter(None, dict.fromkeys(groups)):
        chosen = groups == group
        figures |= {f"{ERROR}/{group}": float(squares[chosen].mean()), f"{LEFT}/{group}": float(sd[chosen].mean())}
    return figures
