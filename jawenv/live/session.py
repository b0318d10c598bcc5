"""A drive of one patient, step by step, with the environment and its filter; it knows nothing of any page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

import jawenv.envs.registration  # noqa: F401  (the ids)
from jawenv.answers.tension import Tension, tensions_of
from jawenv.base.errors import InputError, not_among, reason_of
from jawenv.controls import takes_targets
from jawenv.device.channels import HIGHEST, LOWEST
from jawenv.device.comfort import COMFORT_LIMITS
from jawenv.envs.shown_world import build_scene
from jawenv.live.deciding import Deciding
from jawenv.live.outcome import KNOWN, DriveOutcome
from jawenv.live.setup import Setup
from jawenv.live.steering import Steering
from jawenv.metrics.standing import standing
from jawenv.playing.agents import Agent, Array, introduce
from jawenv.playing.maneuvers import Maneuver, maneuver_names
from jawenv.playing.maneuvers.written import maneuver_of_targets, save_maneuver
from jawenv.recordings.files import save_record
from jawenv.recordings.of_simulation import record_of
from jawenv.recordings.record import Record
from jawenv.rendering.scene import Scene

BY_HAND = "you"
WORTH_NAMING = 0.1
"""Share of the discomfort from which a limit is named."""
_LIMITS = np.array(LOWEST), HIGHEST


@dataclass(frozen=True)
class Shown:
    """One moment, as a page shows it."""

    scene: Scene  # jaw, belief and comfort
    targets: Array  # (4,) what was asked for, as fractions of the patient's comfort
    driver: str  # who drove: ``you``, or the name of a maneuver
    outcome: DriveOutcome  # what has been reached so far
    misfit: float  # the filter's alarm, above 1 where nothing that it could believe explains the readings
    stands: NDArray[np.bool_]  # (M,) on which muscles the data had a verdict, by the last settled belief
    spent_on: tuple[str, ...]  # comfort limits that cost a tenth or more of the discomfort so far, the dearest first
    ended: bool  # whether the episode is over
    why: str  # why it ended; empty while it goes on


class DriveSession:
    """One patient who is driven; ``begin`` starts an episode, ``drive`` makes a control step.

    Args:
        setup: whom, and how.
        agents: who may drive beside the maneuvers, agents of targets control by name.

    Attributes:
        setup: as given.
        agents: as given.
        steering: who says where the jaw is to go.
    """

    def __init__(self, setup: Setup, agents: Mapping[str, Agent] | None = None) -> None:
        self.setup, self.agents = setup, dict(agents or {})
        made: Any = gym.make(setup.world.env_id, disable_env_checker=True, **setup.world.arguments)
        self._env = made.unwrapped
        self.steering = Steering(setup.world.control, setup.world.steps_per_s)
        self.begin()

    def begin(self) -> Shown:
        """Start the episode anew: the same patient with the same noise, at rest."""
        driver = self.steering.driver
        self.steering = Steering(self.setup.world.control, self.setup.world.steps_per_s)
        self.steering.driver = driver
        if isinstance(driver, Deciding):
            driver.begin()
        introduce(self.steering, self._env)
        self._observation, info = self._env.reset(seed=self.setup.seed)
        self._times: list[float] = []
        self._targets: list[Array] = []
        self._reached = dict.fromkeys(KNOWN, np.inf)
        self._note_sd(info)
        self._discomfort_s = 0.0
        self._costs_s = np.zeros(len(COMFORT_LIMITS))
        self._violated, self._ended, self._why = False, False, ""
        self._drivers: set[str] = set()
        self._misfit, self._stands = 0.0, np.zeros(len(info["belief_mean"]) // 2, dtype=np.bool_)
        return self.shown()

    def hand_over(self, name: str) -> None:
        """Let a maneuver, an agent or the hand drive.

        Args:
            name: of an agent or a maneuver that comes with jawenv, the path of a maneuver file, or ``you``.
        """
        if name == BY_HAND:
            # The hand goes on from where the jaw was sent.
            self.steering.hand = np.clip(self.steering.asked, *_LIMITS)
            self.steering.driver = None
        elif name in self.agents:
            self.steering.driver = self._deciding(name)
        elif Path(name).suffix:
            self.steering.driver = Maneuver.load(name)
        elif name in maneuver_names():
            self.steering.driver = Maneuver.named(name)
        else:
            raise not_among("driver", name, (BY_HAND, *self.agents, *maneuver_names()))

    def _deciding(self, name: str) -> Deciding:
        if not takes_targets(self.setup.world.control):
            raise InputError(f"control is {self.setup.world.control}; allowed where {name} drives: targets")
        introduce(self.agents[name], self._env)
        deciding = Deciding(name, self.agents[name], self.setup.world.steps_per_s)
        deciding.try_out(self._observation)
        return deciding

    @property
    def driver(self) -> str:
        """Name of the present driver."""
        return BY_HAND if self.steering.driver is None else self.steering.driver.name

    @property
    def steps(self) -> int:
        """Control steps of this episode so far."""
        return len(self._times)

    @property
    def ended(self) -> bool:
        """Whether the episode is over."""
        return self._ended

    def drive(self, targets: object | None = None) -> Shown:
        """One control step; nothing moves after the end of the episode.

        Args:
            targets: (4,) where the hand wants the jaw; as before where it is None. A maneuver that drives ignores it.
        """
        if targets is not None:
            self.steering.set_hand(targets)
        if self._ended:
            return self.shown()
        action, _ = self.steering.predict(self._observation, episode_start=np.array([not self._times]))
        self._observation, _, terminated, truncated, info = self._env.step(action)
        self._times.append((len(self._times) + 1) / self.setup.world.steps_per_s)
        self._targets.append(np.clip(self.steering.asked, *_LIMITS))
        self._note_sd(info)
        self._discomfort_s += info["cost"] / self.setup.world.steps_per_s
        self._costs_s += self._env.simulation.worlds["truth"]["costs"][0] / self.setup.world.steps_per_s
        self._violated |= bool(info["violation"])
        self._misfit = float(info["misfit"])
        if info["settled"]:
            self._stands = standing(info["belief_mean"], info["belief_cov"], self._env.prior.sd)
        self._drivers.add(self.driver)
        self._ended = bool(terminated or truncated)
        if terminated:
            self._why = "a hard limit was crossed" if self._violated else "the filter lost the jaw"
        elif truncated:
            self._why = "the time is over"
        return self.shown()

    def shown(self) -> Shown:
        """The present moment."""
        return Shown(
            build_scene(self._env.simulation),
            self.steering.asked.copy(),
            self.driver,
            self.outcome(),
            self._misfit,
            self._stands,
            self._spent_on(),
            self._ended,
            self._why,
        )

    def _spent_on(self) -> tuple[str, ...]:
        dear = np.flatnonzero(self._costs_s > WORTH_NAMING * self._costs_s.sum())
        return tuple(COMFORT_LIMITS[i] for i in sorted(dear.tolist(), key=lambda i: -self._costs_s[i]))

    def outcome(self) -> DriveOutcome:
        """The drive's outcome so far."""
        ten, five = self._reached.values()
        return DriveOutcome(self._name(), (ten, five), self._worst_sd, self._discomfort_s, self._time_s, self._violated)

    @property
    def _time_s(self) -> float:
        return self._times[-1] if self._times else 0.0

    def _note_sd(self, info: dict[str, Any]) -> None:
        """Keep the worst sd, and when it was first small enough."""
        self._worst_sd = float(info["belief_sd"].max())
        for threshold, reached in self._reached.items():
            if self._worst_sd <= threshold and np.isinf(reached) and info["settled"]:
                self._reached[threshold] = self._time_s

    def _name(self) -> str:
        """Names of all who have driven in this episode."""
        return " and ".join(sorted(self._drivers, reverse=True)) or BY_HAND

    def maneuver(self, name: str) -> Maneuver:
        """This episode's drive, as a maneuver."""
        if not self._targets:
            raise InputError("drive: nothing was driven; allowed: one step or more")
        title, driven = name.replace("_", " ").capitalize(), f"Driven by hand for {self._time_s:g} s."
        header = {"name": name, "title": title, "description": driven, "source": "jawenv live"}
        return maneuver_of_targets(np.array(self._targets), 1.0 / self.setup.world.steps_per_s, header)

    def record(self) -> Record:
        """The device's record of this episode."""
        if not self._times:
            raise InputError("recording: nothing was driven; allowed: one step or more")
        return record_of(self._env.simulation, 0)

    def forces(self) -> list[Tension]:
        """Closing force of all muscles at the incisors as the filter has it, at openings that the drive reached."""
        mean, cov = (self._env.simulation.worlds[0]["known"]["belief"][name] for name in ("mean", "cov"))
        return tensions_of(self.record(), mean, cov)["all"]

    def save(self, folder: Path, path: Path | None = None) -> list[Path]:
        """Write what was driven: a maneuver file and a recording beside it.

        Args:
            folder: made where it is missing.
            path: of the maneuver file; by default one with a number that none in the folder has.

        Returns:
            The files.
        """
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{folder}: cannot be made: {reason_of(error)}") from None
        number = 1
        while path is None and (folder / f"my_drive_{number}.yaml").exists():
            number += 1
        path = path or folder / f"my_drive_{number}.yaml"
        save_maneuver(self.maneuver(path.stem), path)
        save_record(self.record(), path.with_suffix(".csv"))
        return [path, path.with_suffix(".csv")]
