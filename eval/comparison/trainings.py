"""What training gains: entries of several seeds together, against a reference and against their own replays.

A policy is a draw of its training as a patient is one of the cohort. So both seeds and patients are resampled, each
with all values of the other (the pigeonhole bootstrap; Owen 2007, Annals of Applied Statistics 1:386).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from eval import statistics
from eval.comparison.results import Results
from eval.rows.outcomes import EARLY_S
from eval.statistics import Array, Interval

_SEED = re.compile(r"(?P<stem>.+)-seed\d+")
_KINDS = ("replay", "yoked replay")  # of `eval.replays.add_replays`, in its order


def _log(values: Array) -> Array:
    return np.log(values)


def _same(values: Array) -> Array:
    return values


class Figure(NamedTuple):
    """A figure whose differences are taken.

    Attributes:
        title: what the difference is of.
        value: what of a patient's figure is compared.
        digits: decimals.
    """

    title: str
    value: Callable[[Array], Array]
    digits: int


FIGURES: MappingProxyType[str, Figure] = MappingProxyType(
    {
        "early_worst_sd": Figure(f"log of the worst sd, {EARLY_S:g} s", _log, 3),
        "worst_sd": Figure("log of the worst sd, end", _log, 3),
        "early_rmse": Figure(f"log of the true error, {EARLY_S:g} s", _log, 2),
        "rmse": Figure("log of the true error, end", _log, 2),
        "early_information_true": Figure(f"true nats, {EARLY_S:g} s", _same, 2),
        "information_true": Figure("true nats, end", _same, 2),
        "discomfort_s": Figure("discomfort, s", _same, 3),
    }
)
"""By the columns of the patients' table."""


@dataclass(frozen=True)
class Gain:
    """A policy, or all seeds of its training, against another entry on the same patients and noise.

    Attributes:
        name: label of the entry, or what the labels of its seeds begin with.
        against: label of the reference, or ``its replay`` and ``its yoked replay``.
        seeds: how many trainings.
        figures: of each of `FIGURES` the mean difference over seeds and patients.
    """

    name: str
    against: str
    seeds: int
    figures: dict[str, Interval]


def gains(study: Results, reference: str | None) -> tuple[Gain, ...]:
    """Every trained or planned entry against the reference and its replays; after several seeds all of them together.

    Args:
        study: a comparison.
        reference: label of the entry that all are compared with; None to compare with replays alone.
    """
    about = study.about.get("entries", [])
    made = [each for each in about if each.get("trained") or each.get("planned")]
    trained = [each["label"] for each in made if each["label"] != reference]
    replays = {label: [each["label"] for each in about if each.get("replay_of") == label] for label in trained}
    found: list[Gain] = []
    for name, group in _groups(trained):
        if reference is not None:
            found += _of(study, name, group, [reference] * len(group), reference)
        for place, kind in enumerate(_KINDS):
            if all(len(replays[label]) > place for label in group):
                found += _of(study, name, group, [replays[label][place] for label in group], f"its {kind}")
    return tuple(found)


def _groups(labels: Sequence[str]) -> list[tuple[str, list[str]]]:
    """Labels by what they begin with, the name of that first; one that ends in no seed is alone."""
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
        figure: np.array(
            [
                value(study.of(own)[figure].to_numpy()) - value(study.of(other)[figure].to_numpy())
                for own, other in zip(group, others, strict=True)
            ]
        )
        for figure, (_, value, _) in FIGURES.items()
    }
    found = [
        Gain(label, against, 1, {figure: statistics.mean(rows[k]) for figure, rows in differences.items()})
        for k, label in enumerate(group)
    ]
    if len(group) > 1:
        together = {figure: statistics.mean_over_both(rows) for figure, rows in differences.items()}
        found.append(Gain(name, against, len(group), together))
    return found
