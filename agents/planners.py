"""The planners that come with the project, by name."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from types import MappingProxyType
from typing import Protocol

from agents.clairvoyant import Clairvoyant
from agents.planning import Planner
from agents.sampling_planner import SamplingPlanner
from jawenv.controls import Control


class _MakesPlanner(Protocol):
    """Makes a planner for a control mode, or raises ``InputError``."""

    def __call__(self, *, control: Control) -> Planner: ...  # noqa: D102


PLANNERS: Mapping[str, _MakesPlanner] = MappingProxyType(
    {
        "myopic": partial(SamplingPlanner, "myopic"),
        "clairvoyant_myopic": partial(SamplingPlanner, "clairvoyant_myopic", clairvoyant=True),
        "clairvoyant": partial(Clairvoyant, "clairvoyant"),
    }
)
"""Name -> what makes it."""
