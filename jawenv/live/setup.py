"""Whom a session drives, and how: model, cohort, patient, control and knowledge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

from jawenv.anatomy import Anatomy
from jawenv.checks import real_number, whole_number
from jawenv.controls import DEFAULT_CONTROL, Control
from jawenv.device.comfort_settings import Comfort
from jawenv.device.force_sensor import ForceSensor
from jawenv.errors import InputError, shown
from jawenv.files import Source
from jawenv.ladder import model_named
from jawenv.playing.rollout import LARGEST_SEED

Known = Literal["exact", "imaged"]
SHORTEST_S, LONGEST_S = 1.0, 600.0  # of an episode: the device's readings are kept


@dataclass(frozen=True)
class Setup:
    """What an environment is made of for a drive.

    Attributes:
        seed: of the patient and its noise, as ``reset`` takes it.
        cohort: population that the patient is drawn from: a name, or the path of a file.
        model: one of ``jawenv.ladder.MODELS``.
        control: control mode. Targets are what the hand sets in each; in the other two the device's law makes
            commands of them.
        knowledge: what the filter knows of anatomy and device.
        episode_s: length of an episode, 1 to 600 s.
        force_sensor: how the device knows its force.
        comfort: limits that differ from the default's, as the environment takes them.
        anatomy: what differs from the default anatomy, likewise.

    Raises:
        InputError: a value is not allowed. What the environment refuses, it refuses when it is made.
    """

    seed: int = 0
    cohort: str = "trismus"
    model: str = "jaw"
    control: Control = DEFAULT_CONTROL
    knowledge: Known = "exact"
    episode_s: float = 30.0
    force_sensor: ForceSensor = "cell"
    comfort: Comfort | Source | None = None
    anatomy: Anatomy | Source | None = None

    def __post_init__(self) -> None:
        """Check what no environment checks."""
        seed = whole_number(self.seed)
        if seed is None or not 0 <= seed <= LARGEST_SEED:
            raise InputError(f"seed: {shown(self.seed)} given, allowed is a whole number, 0 to {LARGEST_SEED}")
        if self.knowledge not in get_args(Known):
            raise InputError(f"knowledge: {shown(self.knowledge)} given, allowed are {', '.join(get_args(Known))}")
        length = real_number(self.episode_s)
        if length is None or not SHORTEST_S <= length <= LONGEST_S:
            raise InputError(f"episode_s: {shown(self.episode_s)} given, allowed are {SHORTEST_S:g} to {LONGEST_S:g} s")
        model_named(self.model)

    @property
    def control_hz(self) -> float:
        """Control steps per second: 20 in every mode, so that a hand feels no delay."""
        return 20.0

    @property
    def env_id(self) -> str:
        """Gymnasium's id of the model."""
        return model_named(self.model).env_id

    @property
    def env_kwargs(self) -> dict[str, Any]:
        """Arguments of the environment."""
        return {
            "control": self.control,
            "control_hz": self.control_hz,
            "cohort": self.cohort,
            "episode_s": self.episode_s,
            "knowledge": self.knowledge,
            "force_sensor": self.force_sensor,
            "comfort": self.comfort,
            "anatomy": self.anatomy,
            "record": True,
        }
