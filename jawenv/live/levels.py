"""Levels of the game by name: whose jaw is driven, what is known of it, and how long the bars stay hidden."""

from __future__ import annotations

from dataclasses import dataclass

from jawenv.anatomy.knowledge import LEVELS as KNOWLEDGE
from jawenv.live.setup import Setup


@dataclass(frozen=True)
class Level:
    """One level."""

    title: str  # as the page shows it
    cohort: str  # name of the patients
    knowledge: str = "exact"  # name of what the filter knows of anatomy and device
    hidden_s: float = 0.0  # time at the begin in which no bars are shown, s


GAME = (
    Level("one side, healthy or not", "one_sided", hidden_s=20.0),
    Level("anyone", "anyone"),
    Level("scan anatomy", "anyone", "imaged"),
)
"""From easy to hard."""
OWN = Level("own", "")
"""Of every other patient."""


def level_of(setup: Setup) -> Level:
    """The level that a setup belongs to."""
    name, knowledge = setup.world.build_cohort().name, setup.world.build_knowledge()
    return next((one for one in GAME if one.cohort == name and KNOWLEDGE[one.knowledge] == knowledge), OWN)
