"""The cells of a study file: every entry under every setting."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import product
from typing import Any

from eval.figures.catalogue import FIGURES
from eval.kept.cells import Cell
from eval.kept.entries import Entry, load_entry
from eval.rows.outcomes import Outcomes
from eval.studies.design import Choice, Design, EnvironmentChoice, Pair
from jawenv.base.errors import InputError
from jawenv.envs.configuration import Configuration

PATIENTS_IN_A_PART = 20
FACTORS = ("environment", "cohort", "control", "sensors", "force_sensor", "reality", "control_hz", "entry")
"""Factors of a cell, in the order of the columns."""


Levels = tuple[Any, ...]
"""The values of `FACTORS`."""


def cells_of(design: Design, trust: bool = False) -> tuple[Cell, ...]:
    """All cells, in the order of the file.

    Args:
        design: the study.
        trust: whether stable-baselines3 checkpoints may be unpickled.
    """
    cells = tuple(cell for environment in design.environments for cell in _of_environment(design, environment, trust))
    for pair in design.pairs:
        if not matches(pair, [tuple(cell.levels.values()) for cell in cells], design):
            names = ", ".join(dict.fromkeys(str(cell.levels["entry"]) for cell in cells))
            raise InputError(
                f"pairs: no two cells are '{pair[0]}' and '{pair[1]}' and alike in all else; entries are {names}; "
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
    compared = [index for index, factor in enumerate(FACTORS) if factor != "control_hz" or design.control_hz]
    by_place = {tuple(levels[index] for index in compared): levels for levels in every}
    one, other = pair[0].given, pair[1].given
    pairs = []
    for levels in every:
        fields = dict(zip(FACTORS, levels, strict=True))
        other_levels = tuple((fields | other).values())
        partner = by_place.get(tuple(other_levels[index] for index in compared), levels)
        if all(fields[factor] == value for factor, value in one.items()) and partner != levels:
            pairs.append((levels, partner))
    return pairs


def _of_environment(design: Design, environment: EnvironmentChoice, trust: bool) -> Iterator[Cell]:
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
            **({"knowledge": environment.knowledge} if environment.knowledge else {}),
            "control_hz": hz,
        }
        world = Configuration.from_mapping(fields)
        labels: dict[str, str] = {}
        for choice in design.entries:
            if control in (choice.controls or design.controls) and cohort_name in (choice.cohorts or design.cohorts):
                entry = _checked(choice, world, labels, trust)
                levels = environment.name, cohort_name, control, sensors, force_sensor, reality, world.steps_per_s
                number = min(choice.patients or design.patients, design.patients)
                yield Cell(
                    dict(zip(FACTORS, (*levels, entry.label), strict=True)),
                    partial(load_entry, choice.agent, world, trust=trust),
                    range(design.seed, design.seed + number),
                    Outcomes(bound=any(FIGURES[name].bound for name in design.metrics), over_time=False),
                    getattr(entry.agent, "together", PATIENTS_IN_A_PART),
                )


def _checked(choice: Choice, asked: Configuration, labels: dict[str, str], trust: bool) -> Entry:
    """An entry with a label of its own among the entries so far."""
    entry = load_entry(choice.agent, asked, trust=trust)
    if entry.world != asked:
        raise InputError(
            f"entries: {choice.agent} is {entry.note}, but the study asks for control {asked.control}, sensors "
            f"{asked.sensors}; allowed: what it was trained with, also as "
            f"{{agent: {choice.agent}, controls: [...]}}"
        )
    if entry.label in labels:
        raise InputError(
            f"entries: {choice.agent} and {labels[entry.label]} are both called {entry.label!r}; allowed: one of a name"
        )
    labels[entry.label] = choice.agent
    return entry
