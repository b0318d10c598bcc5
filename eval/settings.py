"""On whom and how is played."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import asdict, dataclass, field
from typing import Any

from jawenv.anatomy import anatomy_of, cohort
from jawenv.anatomy.knowledge import knowledge
from jawenv.controls import CONTROLS, DEFAULT_CONTROL
from jawenv.device.comfort_settings import comfort_of
from jawenv.device.device import device_of
from jawenv.device.force_sensor import FORCE_SENSORS
from jawenv.errors import InputError, shown
from jawenv.ladder import env_id_of, model_of_env
from jawenv.playing.rollout import DEFAULT_ENV, LARGEST_SEED
from jawenv.reality import check_reality
from jawenv.seeds import REPORTS

SENSORS = ("pose", "point")


@dataclass(frozen=True)
class Settings:
    """On whom and how maneuvers and agents are played.

    Attributes:
        patients: how many, >= 1; patient i is drawn, and its noise made, by the seed `seed + i`.
        cohort: name of the population they are drawn from.
        seed: of the first patient, 0 to 2**32 - 1.
        control: `force`, `trajectory` or `targets`.
        sensors: `pose` or `point`.
        episode_s: length of every episode, > 0.
        env: id of the environment; as given, also its short name or its model's.
        device: fields of `jawenv.Device` with other values, which the filter knows; none by default.
        reality: effects that the filter does not know, fields of `jawenv.reality.Reality`; none by default.
        estimator: mechanics that the filter believes in; the environment's own by default.
        knowledge: what the filter knows within sds beside the muscles, fields of `jawenv.Knowledge`; all exactly by
            default.
        control_hz: control steps per second; the control's own by default.
        force_sensor: `cell`, `motors` or `straps`.
        comfort: fields of `jawenv.Comfort` with other values; none by default.
        anatomy: what differs from the default anatomy, as `jawenv.Anatomy.from_dict` takes it; nothing by default.

    Raises:
        InputError: a value is not allowed.
    """

    patients: int = 64
    cohort: str = "trismus"
    seed: int = REPORTS[0].start
    control: str = DEFAULT_CONTROL
    sensors: str = "pose"
    episode_s: float = 30.0
    env: str = DEFAULT_ENV
    reality: dict[str, float] = field(default_factory=dict)
    device: dict[str, float] = field(default_factory=dict)
    estimator: str | None = None
    knowledge: dict[str, float] = field(default_factory=dict)
    control_hz: float | None = None
    force_sensor: str = "cell"
    comfort: dict[str, float] = field(default_factory=dict)
    anatomy: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check every value, and spell the environment's id out."""
        model = model_of_env(self.env)
        object.__setattr__(self, "env", env_id_of(self.env))
        if self.patients < 1:
            raise InputError(f"patients: {self.patients} given, allowed is 1 or more")
        if not 0 <= self.seed <= LARGEST_SEED:
            raise InputError(f"seed: {self.seed} given, allowed is a whole number, 0 to {LARGEST_SEED}")
        if not (math.isfinite(self.episode_s) and self.episode_s > 0.0):
            raise InputError(f"episode_s: {self.episode_s} given, allowed is a number of seconds above 0")
        texts: tuple[tuple[str, str, Collection[str]], ...] = (
            ("control", self.control, CONTROLS),
            ("sensors", self.sensors, SENSORS),
            ("force_sensor", self.force_sensor, FORCE_SENSORS),
        )
        for name, value, allowed in texts:
            if value not in allowed:
                raise InputError(f"{name}: {shown(value)} given, allowed are {', '.join(allowed)}")
        if self.estimator not in (None, *model.estimators):
            known = ", ".join(model.estimators)
            raise InputError(f"estimator: {shown(self.estimator)} given, allowed in {self.env} are {known}")
        cohort(self.cohort)
        check_reality(self.reality)
        device_of(self.device)
        knowledge(self.knowledge)
        comfort_of(self.comfort)
        anatomy_of(self.anatomy)

    def of_a_patient(self) -> dict[str, Any]:
        """What decides a patient's row: all but how many there are and from which seed on; the cohort is whole."""
        fields = asdict(self) | {"cohort": cohort(self.cohort).to_dict()}
        return {name: value for name, value in fields.items() if name not in ("patients", "seed")}

    @property
    def env_kwargs(self) -> dict[str, Any]:
        """Arguments of the environment."""
        given: dict[str, Any] = {
            "control": self.control,
            "sensors": self.sensors,
            "cohort": self.cohort,
            "episode_s": self.episode_s,
        }
        changed = {
            "reality": self.reality,
            "device": self.device,
            "estimator": self.estimator,
            "knowledge": self.knowledge,
            "control_hz": self.control_hz,
            "comfort": self.comfort,
            "anatomy": self.anatomy,
        }
        if self.force_sensor != "cell":
            given["force_sensor"] = self.force_sensor
        return given | {name: value for name, value in changed.items() if value}
