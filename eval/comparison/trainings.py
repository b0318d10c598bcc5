"""Gains by training: entries of several seeds together, against a reference and against their own replays.

An entry that does better than its own averaged targets, replayed without looking, adapts to its patient.

A policy is a draw of its training as a patient is one of the cohort. So both seeds and patients are resampled, each
with all values of the other (the pigeonhole bootstrap; Owen 2007, Annals of Applied Statistics 1:386).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from eval.comparison.results import Results
from eval.figures import statistics
from eval.figures.catalogue import FIGURES
from eval.figures.statistics import Array, Interval
from eval.rows.outcomes import EARLY_S

_SEED = re.compile(r"(?P<stem>.+)-seed\d+")
_KINDS = ("replay", "yoked replay")  # of `eval.episodes.replays.add_replays`, in its order


class _Difference(NamedTuple):
    """A comparison of a figure patient by patient."""

    title: str  # heading of the difference
    log: bool  # whether it is one of natural logs
    digits: int  # decimals


DIFFERENCES: Mapping[str, _Difference] = MappingProxyType(
    {
        "early_worst_sd": _Difference(f"log of the worst sd, {EARLY_S:g} s", True, 3),
        "worst_sd": _Difference("log of the worst sd, end", True, 3),
        "early_rmse": _Difference(f"log of the true error, {EARLY_S:g} s", True, 2),
        "rmse": _Difference("log of the true error, end", True, 2),
        "early_information_true": _Difference(f"true nats, {EARLY_S:g} s", False, 2),
        "information_true": _Difference("true nats, end", False, 2),
        "discomfort_s": _Difference("discomfort, s", False, 3),
    }
)
"""Differences of figures of the catalogue, by their names."""


@dataclass(frozen=True)
class Gain:
    """A policy, or all seeds of its training, against another entry on the same patients and noise."""

    name: str  # label of the entry, or common beginning of the labels of its seeds
    against: str  # label of the other, or ``its replay`` and ``its yoked replay``
    seeds: int  # how many trainings
    figures: dict[str, Interval]  # of each of `DIFFERENCES` the mean over seeds and patients


def gains(study: Results, reference: str | None) -> tuple[Gain, ...]:
    """Every trained or planned entry against the reference and its replays; after several seeds all of them together.

    Args:
        study: a comparison.
        reference: label of the entry that all are compared with; None to compare with replays alone.
    """
    entries = study.about.get("entries", [])
    made = [entry for entry in entries if entry.get("trained") or entry.get("planned")]
    trained = [entry["label"] for entry in made if entry["label"] != reference]
    replays = {label: replays_of(study, label) for label in trained}
    rows: list[Gain] = []
    for name, group in groups(trained):
        if reference is not None:
            rows += _of(study, name, group, [reference] * len(group), reference)
        for number, kind in enumerate(_KINDS):
            if all(len(replays[label]) > number for label in group):
                rows += _of(study, name, group, [replays[label][number] for label in group], f"its {kind}")
    return tuple(rows)


def replays_of(study: Results, label: str) -> list[str]:
    """Labels of an entry's replay and yoked replay; none if it has none."""
    return [entry["label"] for entry in study.about.get("entries", []) if entry.get("replay_of") == label]


def groups(labels: Sequence[str]) -> list[tuple[str, list[str]]]:
    """Labels grouped by common beginning, name of the group first; a label that ends in no seed is alone."""
    seeds: dict[str, list[str]] = {}
    alone: list[tuple[str, list[str]]] = []
    for label in labels:
        if match := _SEED.fullmatch(label):
            seeds.setdefault(match["stem"], []).append(label)
        else:
            alone.append((label, [label]))
    return [*seeds.items(), *alone]


def _of(study: Results, name: str, group: list[str], others: list[str], against: str) -> list[Gain]:
    """Each of a group against its other, and where there are several all of them together."""
    differences = {
        figure: np.array([difference(study, figure, *pair) for pair in zip(group, others, strict=True)])
        for figure in DIFFERENCES
    }
    gains_of_seeds = [
        Gain(label, against, 1, {figure: statistics.mean(rows[k]) for figure, rows in differences.items()})
        for k, label in enumerate(group)
    ]
    if len(group) > 1:
        together = {figure: statistics.mean_over_both(rows) for figure, rows in differences.items()}
        gains_of_seeds.append(Gain(name, against, len(group), together))
    return gains_of_seeds


def difference(study: Results, figure: str, own: str, other: str) -> Array:
    """(N,) differences of `DIFFERENCES` between two entries, patient by patient."""
    values = (FIGURES[figure].of(study.of(entry)) for entry in (own, other))
    one, reference = map(np.log, values) if DIFFERENCES[figure].log else values
    return one - reference


def adaptations(study: Results) -> tuple[Gain, ...]:
    """Every entry of a study that has a replay against it, in the order in which they were played."""
    entries = study.about.get("entries", [])
    pairs = [(played["replay_of"], played["label"]) for played in entries if played.get("replay_of")]
    return tuple(_of(study, entry, [entry], [replay], replay)[0] for entry, replay in pairs)


def verdict(difference: Interval) -> str:
    """`adapts` where the whole difference of logs is below 0, `does worse` where it is above, else `not shown`."""
    if not difference.exists:
        return "not known"
    if difference.high < 0.0:
        return "adapts"
    return "does worse" if difference.low > 0.0 else "not shown"
