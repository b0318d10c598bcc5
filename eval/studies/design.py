"""A study as its file says it, checked."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, field_validator, model_validator

from eval.figures.catalogue import FIGURES
from jawenv.anatomy import cohort
from jawenv.base.errors import InputError, meant, shown
from jawenv.base.files import FILE_TYPES, InputModel, Number, read_model
from jawenv.controls import DEFAULT_CONTROL, Control
from jawenv.device.force_sensor import ForceSensor
from jawenv.envs.configuration import Sensors
from jawenv.ladder import env_id_of, title_of_env
from jawenv.playing.rollout import LARGEST_SEED
from jawenv.reality import check_reality

FOLDER = Path(__file__).parent
MOST_PATIENTS = 1_000_000
DEFAULT_METRICS = ("information_true", "worst_sd", "time_to_5", "nees_per_parameter", "discomfort_s")


def _named(field: str) -> BeforeValidator:
    """Lets a text stand for a mapping with one field."""
    return BeforeValidator(lambda value: {field: value} if isinstance(value, str) else value)


def _different(values: tuple[Any, ...]) -> tuple[Any, ...]:
    if any(value in values[:index] for index, value in enumerate(values)):
        raise ValueError(f"is {shown(values)}; allowed: each once")
    return values


class Choice(InputModel):
    """A maneuver or agent."""

    agent: str  # as ``python -m eval compare`` takes it
    controls: tuple[Control, ...] | None = None  # control modes that it is played in; all of the study's by default
    cohorts: tuple[str, ...] | None = None  # that it is played on; all of the study's by default
    patients: int | None = Field(default=None, ge=1, le=MOST_PATIENTS)
    """On how many it is played, the first ones; all by default."""


class EnvironmentChoice(InputModel):
    """An environment, and what its filter knows."""

    env: str  # its id, or as `jawenv.ladder.model_of_env` takes it
    knowledge: Literal["exact", "imaged"] | None = None
    """Knowledge of the filter; the environment's own level by default."""
    controls: tuple[Control, ...] | None = None  # control modes that it is played in; all of the study's by default

    @field_validator("env")
    @classmethod
    def _spelt_out(cls, env: str) -> str:
        return title_of_env(env_id_of(env))

    @property
    def name(self) -> str:
        """The name in tables."""
        return self.env + (f", {self.knowledge}" if self.knowledge else "")


class _Side(InputModel):
    """One side of a pair by its own levels; in all others it equals the other side."""

    entry: str | None = None  # label of a maneuver or agent
    control: Control | None = None  # control mode
    sensors: Sensors | None = None  # sensors
    force_sensor: ForceSensor | None = None  # how the device knows its force
    reality: str | None = None  # name of the effects
    control_hz: Number | None = None  # control steps per second

    @property
    def given(self) -> dict[str, Any]:
        """The fields that the file names."""
        return {name: value for name, value in self if value is not None}

    def __str__(self) -> str:
        """The name in tables."""
        return ", ".join(
            str(value) if name == "entry" else f"{name} {value}".removesuffix(".0")
            for name, value in self.given.items()
        )


Pair = tuple[Annotated[_Side, _named("entry")], Annotated[_Side, _named("entry")]]


class Design(InputModel):
    """A study: everything in `entries` is played under every combination of the settings, on the same patients."""

    title: str  # the question
    description: str = ""  # a paragraph for readers
    entries: tuple[Annotated[Choice, _named("agent")], ...] = ()  # maneuvers and agents
    results: tuple[str, ...] = ()  # of Young (2016), see `eval.thesis.catalogue.ITEMS`, in place of entries
    environments: tuple[Annotated[EnvironmentChoice, _named("env")], ...] = Field(
        default=(EnvironmentChoice(env="Jaw"),), min_length=1
    )  # models of the jaw
    cohorts: tuple[str, ...] = Field(default=("trismus",), min_length=1)  # names or files of cohorts
    controls: tuple[Control, ...] = Field(default=(DEFAULT_CONTROL,), min_length=1)  # control modes
    sensors: tuple[Sensors, ...] = Field(default=("pose",), min_length=1)  # `pose` or `point`
    force_sensors: tuple[ForceSensor, ...] = Field(default=("cell",), min_length=1)  # `cell`, `motors` or `straps`
    reality: dict[str, dict[str, Number]] = Field(default={"none": {}}, min_length=1)
    """By a name of one's own, effects that the filter does not know; none by default."""
    control_hz: tuple[Number, ...] = ()  # control steps per second; the default rate of each control by default
    patients: int = Field(ge=1, le=MOST_PATIENTS)
    """How many; patient i is drawn, and its noise made, by the seed `seed + i`. Of results, how many draws."""
    seed: int = Field(ge=0, le=LARGEST_SEED)  # of the first patient
    episode_s: Number = Field(default=30.0, gt=0.0)  # length of every episode, s
    metrics: tuple[str, ...] = Field(default=DEFAULT_METRICS, min_length=1)  # names of `eval.figures.catalogue.FIGURES`
    pairs: tuple[Pair, ...] = ()  # comparisons patient by patient

    @field_validator(
        "entries", "environments", "cohorts", "controls", "sensors", "force_sensors", "control_hz", "metrics"
    )
    @classmethod
    def _no_repeats(cls, values: tuple[Any, ...]) -> tuple[Any, ...]:
        return _different(values)

    @field_validator("cohorts")
    @classmethod
    def _known_cohorts(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        for name in names:
            cohort(name)
        return names

    @model_validator(mode="after")
    def _parts_of_it(self) -> Design:
        if bool(self.entries) == bool(self.results):
            raise ValueError("entries: has none, or results beside them; allowed: one or more, or results alone")
        asked: list[tuple[str, str, tuple[str, ...] | None, tuple[str, ...]]] = []
        asked += [(f"entry {entry.agent!r}", "controls", entry.controls, self.controls) for entry in self.entries]
        asked += [(f"entry {entry.agent!r}", "cohorts", entry.cohorts, self.cohorts) for entry in self.entries]
        asked += [(f"environment {env.name!r}", "controls", env.controls, self.controls) for env in self.environments]
        for whose, name, own, allowed in asked:
            if outside := set(own or ()) - set(allowed):
                which = ", ".join(sorted(outside))
                raise ValueError(f"{whose}: {name} {which}; allowed: the study's, {', '.join(allowed)}")
        return self

    @field_validator("reality")
    @classmethod
    def _known_effects(cls, effects_by_name: dict[str, dict[str, float]]) -> dict[str, dict[str, float]]:
        for effects in effects_by_name.values():
            check_reality(effects)
        return effects_by_name

    @field_validator("metrics")
    @classmethod
    def _known_metrics(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        for name in names:
            if name not in FIGURES:
                raise ValueError(f"names {shown(name)}; allowed: {', '.join(FIGURES)}")
        return names


def shipped() -> Mapping[str, Path]:
    """The studies that come with the project: name -> file."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.yaml"))}


def read(source: str) -> tuple[str, Design]:
    """Read a study by its name or from its file.

    Returns:
        Its name, and the study.
    """
    path = shipped().get(source, Path(source))
    if path.suffix.lower() not in FILE_TYPES:
        names = ", ".join(shipped())
        kinds = ", ".join(FILE_TYPES)
        raise InputError(
            f"study is {shown(source)}; {meant(str(source), shipped())}allowed: {names}, or a file ({kinds})"
        )
    return path.stem, read_model(path, Design)
