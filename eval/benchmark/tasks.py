"""The frozen tasks: a changed task makes a new version of the benchmark."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from types import MappingProxyType
from typing import Any

from eval.kept.entries import Settings
from jawenv.anatomy import cohort
from jawenv.anatomy.knowledge import knowledge
from jawenv.base.errors import InputError, shown
from jawenv.device.device import device_of

VERSION = "jawenv-3"
"""Version for citation, with the ids of the tasks."""
PATIENTS_IN_A_PART = 50
"""Patients that are played together. An agent that draws at random draws anew for each part."""


@dataclass(frozen=True)
class Task:
    """One task: patients, settings and the precision asked of an agent."""

    id: str  # its name
    description: str  # the task in a sentence
    env: str  # id of the environment
    cohort: str  # name of the population
    knowledge: str  # `exact` or `imaged`, the filter's knowledge of anatomy and device
    first_seed: int  # of the first patient; patient i has ``first_seed + i``
    within: float  # largest relative error of every parameter, 0.05 is 5 %
    device: Mapping[str, float] = field(default_factory=dict)
    """Fields of the device with other values, which the filter knows."""
    control: str = "targets"  # the device keeps a budget of discomfort in no other
    episode_s: float = 30.0  # length of every episode
    comfort_budget_s: float = 0.1  # discomfort of an episode that the device keeps: nobody wins by breaking a limit
    patients: int = 100  # how many
    asked: str | None = None  # the muscles that have to be found, as the environment's argument; None for all
    comfort_limit_s: float = math.inf  # discomfort of an episode above which the patient counts as not found

    @property
    def seeds(self) -> range:
        """The seeds of all patients."""
        return range(self.first_seed, self.first_seed + self.patients)

    @property
    def known_within(self) -> dict[str, float]:
        """The sds of the filter's knowledge above 0."""
        return {name: value for name, value in asdict(knowledge(self.knowledge)).items() if value > 0.0}

    def settings(self, patients: int | None = None) -> Settings:
        """The world in which it is played.

        Args:
            patients: the first ones only; all by default.
        """
        world = {"env": self.env, "cohort": self.cohort, "control": self.control, "episode_s": self.episode_s}
        world |= {"device": dict(self.device), "knowledge": self.known_within, "asked": self.asked}
        world |= {"comfort_budget_s": self.comfort_budget_s}
        return Settings.of(patients or self.patients, self.first_seed, **world)

    def frozen(self) -> dict[str, Any]:
        """All that makes the task, with the numbers behind the names, without words and effects that are off."""
        device = asdict(device_of(dict(self.device)))
        return {name: value for name, value in asdict(self).items() if name != "description"} | {
            "cohort": {"name": self.cohort, "groups": cohort(self.cohort).to_dict()["groups"]},
            "knowledge": self.known_within,
            "device": {name: value for name, value in device.items() if value and not name.startswith(_OTHER_SENSORS)},
        }


_JAW = "jawenv/Jaw-v3"
_OTHER_SENSORS = ("motor_table_", "motor_coulomb_", "motor_viscous_", "strap_")  # of a force that no task has
TASKS: Mapping[str, Task] = MappingProxyType(
    {
        task.id: task
        for task in (
            Task(
                "hinge-exact",
                "The closers of a hinge, 2 parameters",
                "jawenv/JawHinge-v3",
                "trismus",
                "exact",
                50_000,
                0.05,
            ),
            Task("jaw-exact", "Every closing muscle of both sides", _JAW, "trismus", "exact", 51_000, 0.05),
            Task("jaw-wide-exact", "The medians of trismus, twice its spread", _JAW, "wide", "exact", 52_000, 0.05),
            Task(
                "jaw-one-sided-exact",
                "All closers of one side are stiff, and it is not told which side",
                _JAW,
                "one_sided",
                "exact",
                53_000,
                0.05,
            ),
            Task(
                "jaw-imaged",
                "Anatomy, mass and fit of the device are known as from a scan",
                _JAW,
                "trismus",
                "imaged",
                54_000,
                0.10,
            ),
            Task(
                "jaw-imaged-memory",
                "As jaw-imaged; the unmodelled wrench has a memory of 0.5 s, and the filter knows it",
                _JAW,
                "trismus",
                "imaged",
                55_000,
                0.20,
                {"unmodelled_time_s": 0.5},
            ),
            Task(
                "jaw-asked",
                "One muscle, drawn and told, in 10 s; above 0.03 s of discomfort a patient counts as not found",
                _JAW,
                "patchy",
                "exact",
                57_000,
                0.02,
                episode_s=10.0,
                comfort_budget_s=0.03,
                asked="random",
                comfort_limit_s=0.03,
            ),
        )
    }
)
"""Every task of this version by its id."""


def tasks_named(names: Iterable[str] | None = None) -> tuple[Task, ...]:
    """Tasks by their ids, in the order of `TASKS`; all by default."""
    ids = list(TASKS if names is None else names)
    for name in ids:
        if name not in TASKS:
            raise InputError(f"tasks is {shown(name)}; allowed: {', '.join(TASKS)}")
    if not ids:
        raise InputError(f"tasks is none; allowed: {', '.join(TASKS)}")
    return tuple(task for name, task in TASKS.items() if name in ids)


def digest() -> str:
    """16 hexadecimal digits for the version, all tasks and the size of a part."""
    content = [VERSION, PATIENTS_IN_A_PART, [task.frozen() for task in TASKS.values()]]
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]
