"""On whom and how is played."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

from jawenv.envs.configuration import Configuration
from jawenv.errors import InputError, shown
from jawenv.playing.rollout import LARGEST_SEED
from jawenv.seeds import REPORTS


@dataclass(frozen=True)
class Settings:
    """On whom and how maneuvers and agents are played.

    Attributes:
        world: the environment and its arguments.
        patients: how many, >= 1; patient i is drawn, and its noise made, by the seed `seed + i`.
        seed: of the first patient, 0 to 2**32 - 1.

    Raises:
        InputError: a value is not allowed.
    """

    world: Configuration = Configuration()
    patients: int = 64
    seed: int = REPORTS[0].start

    def __post_init__(self) -> None:
        """Check the numbers."""
        if self.patients < 1:
            raise InputError(f"patients is {shown(self.patients)}; allowed: a whole number, 1 or more")
        if not 0 <= self.seed <= LARGEST_SEED:
            raise InputError(f"seed is {shown(self.seed)}; allowed: a whole number, 0 to {LARGEST_SEED}")

    @classmethod
    def of(cls, patients: int = 64, seed: int = REPORTS[0].start, **world: Any) -> Self:
        """Settings of ``env`` and arguments, as `Configuration.from_mapping` takes them."""
        return cls(Configuration.from_mapping(world), patients, seed)

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> Self:
        """Settings from a mapping of ``to_mapping``."""
        return cls.of(**mapping)

    def to_mapping(self) -> dict[str, Any]:
        """All in plain values, as results keep it."""
        return {"patients": self.patients, "seed": self.seed, **self.world.to_mapping()}

    @property
    def seeds(self) -> range:
        """Of the patients and their noise."""
        return range(self.seed, self.seed + self.patients)
