"""The cells of a study: every entry under every setting."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from eval.comparison import results
from eval.entries import Entry, load_entries
from eval.kept.digest import fingerprint
from eval.settings import Settings
from eval.studies.design import Choice, Design, Environment, Pair
from jawenv.envs.configuration import Configuration
from jawenv.errors import InputError

FACTORS = ("environment", "cohort", "control", "sensors", "force_sensor", "reality", "control_hz", "entry")
"""What tells cells apart, in the order of the columns."""


Levels = tuple[Any, ...]
"""The values of `FACTORS`."""


@dataclass(frozen=True)
class Cell:
    """One entry under one setting.

    Attributes:
        environment: name of the environment, with its filter where that is not its own.
        cohort: name or file of the cohort.
        control: control mode.
        sensors: sensors.
        force_sensor: how the device knows its force.
        reality: name of the effects.
        control_hz: control steps per second.
        entry: label.
        spec: what the entry is loaded by.
        settings: on whom and how it is played.
        planned: whether the entry is a planner, which takes long.
        trust: whether its checkpoint may be unpickled.
    """

    environment: str
    cohort: str
    control: str
    sensors: str
    force_sensor: str
    reality: str
    control_hz: float
    entry: str
    spec: str
    settings: Settings
    planned: bool
    trust: bool = False

    @property
    def levels(self) -> Levels:
        """The values of `FACTORS`."""
        return tuple(getattr(self, factor) for factor in FACTORS)

    def load(self) -> Entry:
        """The entry, ready to be played."""
        return load_entries([self.spec], self.settings.world, trust=self.trust)[0]

    def fingerprint(self, bound: bool = False) -> str:
        """The digest of a patient's row, which may have the bound."""
        settings = self.settings.of_a_patient() | {"label": self.entry, "bound": bound}
        return fingerprint(self.load(), settings, results)


def cells_of(design: Design, trust: bool = False) -> tuple[Cell, ...]:
    """All cells, in the order of the file.

    Args:
        design: the study.
        trust: whether checkpoints that lie in no run's folder may be unpickled.

    Raises:
        InputError: an unknown entry, one that another setting was trained for, two of one name, settings that no
            environment takes, or a pair that no two cells fit.
    """
    cells = tuple(cell for environment in design.environments for cell in _of_environment(design, environment, trust))
    for pair in design.pairs:
        if not matches(pair, [cell.levels for cell in cells], design):
            known = ", ".join(dict.fromkeys(cell.entry for cell in cells))
            raise InputError(
                f"pairs: no two cells are '{pair[0]}' and '{pair[1]}' and alike in all else; entries are {known}; "
                f"reality is {', '.join(design.reality)}"
            )
    return cells


def matches(pair: Pair, every: Sequence[Levels], design: Design) -> list[tuple[Levels, Levels]]:
    """The cells that fit the first side of a pair, each with the cell that differs from it by the second side alone.

    Where the study names no rates, each control has its own, so that two controls differ by their rates as well.

    Args:
        pair: the sides.
        every: levels of all cells.
        design: the study.
    """
    compared = [place for place, factor in enumerate(FACTORS) if factor != "control_hz" or design.control_hz]
    by_place = {tuple(levels[place] for place in compared): levels for levels in every}
    one, other = pair[0].given, pair[1].given
    found = []
    for levels in every:
        fields = dict(zip(FACTORS, levels, strict=True))
        wanted = tuple((fields | other).values())
        partner = by_place.get(tuple(wanted[place] for place in compared), levels)
        if all(fields[factor] == value for factor, value in one.items()) and partner != levels:
            found.append((levels, partner))
    return found


def _of_environment(design: Design, environment: Environment, trust: bool) -> Iterator[Cell]:
    rates = design.control_hz or (None,)
    controls = environment.controls or design.controls
    settings = product(design.cohorts, controls, design.sensors, design.force_sensors, design.reality, rates)
    for cohort_name, control, sensors, force_sensor, reality, hz in settings:
        fields: dict[str, Any] = {
            "cohort": cohort_name,
            "control": control,
            "sensors": sensors,
            "force_sensor": force_sensor,
            "episode_s": design.episode_s,
            "env": environment.env,
            "reality": design.reality[reality],
            "estimator": environment.estimator,
            "control_hz": hz,
        }
        world = Configuration.from_mapping(fields)
        labels: dict[str, str] = {}
        for choice in design.entries:
            if control in (choice.controls or design.controls) and cohort_name in (choice.cohorts or design.cohorts):
                number = min(choice.patients or design.patients, design.patients)
                asked = Settings(world, number, design.seed)
                entry = _checked(choice, asked, labels, trust)
                place = environment.name, cohort_name, control, sensors, force_sensor, reality, world.steps_per_s
                yield Cell(*place, entry.label, choice.agent, asked, entry.planned, trust)


def _checked(choice: Choice, asked: Settings, labels: dict[str, str], trust: bool) -> Entry:
    """An entry, whose label must be another one than those of the entries before.

    Raises:
        InputError: it plays other settings than those asked for, or has the label of another entry.
    """
    entry = load_entries([choice.agent], asked.world, trust=trust)[0]
    if entry.world != asked.world:
        raise InputError(
            f"entries: {choice.agent} is {entry.note}, but the study asks for control {asked.world.control}, sensors "
            f"{asked.world.sensors}; allowed: what it was trained with, also as "
            f"{{agent: {choice.agent}, controls: [...]}}"
        )
    if entry.label in labels:
        raise InputError(
            f"entries: {choice.agent} and {labels[entry.label]} are both called {entry.label!r}; allowed: one of a name"
        )
    labels[entry.label] = choice.agent
    return entry
