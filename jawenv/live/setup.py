"""Whom a session drives, and how: a world and the patient's seed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Self

from jawenv.base.errors import InputError, shown
from jawenv.base.numeric_fields import whole_number
from jawenv.envs.configuration import Configuration
from jawenv.playing.rollout import LARGEST_SEED

CONTROL_HZ = 20.0  # in every mode, so that a hand feels no delay
SHORTEST_S, LONGEST_S = 1.0, 600.0  # of an episode: the device's readings are kept


@dataclass(frozen=True)
class Setup:
    """The environment and the patient of a drive."""

    world: Configuration = Configuration()
    """The environment. Targets are what the hand sets in every control mode; in two of them the device's law makes
    commands of them. It has 20 control steps per second, and keeps what the device measures.
    """
    seed: int = 0  # of the patient and its noise, as ``reset`` takes it

    def __post_init__(self) -> None:
        """Check what no environment checks, and set what every drive has."""
        seed = whole_number(self.seed)
        if seed is None or not 0 <= seed <= LARGEST_SEED:
            raise InputError(f"seed is {shown(self.seed)}; allowed: a whole number, 0 to {LARGEST_SEED}")
        if not SHORTEST_S <= self.world.episode_s <= LONGEST_S:
            raise InputError(f"episode_s is {self.world.episode_s:g}; allowed: {SHORTEST_S:g} to {LONGEST_S:g} s")
        object.__setattr__(self, "world", replace(self.world, control_hz=CONTROL_HZ, record=True))

    @classmethod
    def of(cls, seed: int = 0, **world: Any) -> Self:
        """A setup of ``env`` and arguments, as ``Configuration.from_mapping`` takes them."""
        return cls(Configuration.from_mapping(world), seed)
