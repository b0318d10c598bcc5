"""A contest: each entry's share of the gap between the best fixed maneuver and a planner that knows the patient.

Of every comparison all seeds of one training are one row (``trainings``). Figures are of the end of the episode, and
differences patient by patient. The best fixed maneuver is the one of the smallest mean log of the worst sd among those
within the admitted discomfort.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from eval.comparison.admission import AdmissionLimits
from eval.comparison.cost import Cost, cost
from eval.comparison.ranking import KNOWN
from eval.comparison.results import Results
from eval.comparison.trainings import groups, replays_of
from eval.figures import statistics, words
from eval.figures.catalogue import FIGURES, above_limit, per_30_s
from eval.figures.statistics import UNKNOWN, Array, Interval
from eval.figures.tables import Table, made_by
from eval.kept.entries import Settings
from jawenv.base.errors import InputError

_NOTE = (
    "Sure: seconds until no error bar asked for is above 5 %, nine in ten patients sooner. Verdicts: until the data "
    "have one on every muscle, for good. Who never gets there counts as the whole episode. Worst sd, true error: mean "
    "log of the largest sd asked for and of the root mean square error, less that of the best fixed maneuver, patient "
    "by patient; below 0 is better. Closed: the share of the way from that maneuver to the clairvoyant. Replay, yoked: "
    "mean log of the worst sd less that of the entry's own and yoked replay. Above: share of the patients with more "
    "discomfort than is admitted on average. Training: steps of the environment or of its twin. A decision: of one "
    "patient, timed where this page was made; of the clairvoyant the time in which the comparison planned for its "
    "patients together, over their number. In brackets the 95 % interval over patients, and over the seeds of a "
    "training."
)
_DIGITS = {
    "sure, s": 2,
    "nine in ten, s": 1,
    "verdicts, s": 2,
    "worst sd": 3,
    "closed, %": 0,
    "true error": 2,
    "replay": 3,
    "yoked": 3,
    "discomfort, s": 3,
    "above, %": 0,
    "NEES / p": 2,
}
"""Heading of each figure -> decimals."""
_OF_BOUND = 12
"""Patients of the static bound."""
_HEAD = ("entry", "seeds", *_DIGITS, "training, steps", "a decision, ms")


@dataclass(frozen=True)
class _Contestant:
    """One row; see ``_NOTE``."""

    name: str  # label of the entry, or the common beginning of those of its seeds
    seeds: int  # how many trainings
    figures: tuple[Interval, ...]  # those of ``_DIGITS``
    about: Mapping[str, Any]  # metadata of the entry, of several seeds that of the first


def contestants(study: Results, admission: AdmissionLimits | None = None) -> tuple[_Contestant, ...]:
    """Every entry but replays, seeds of one training together, the best first.

    Args:
        study: a comparison.
        admission: limits of comfort; the defaults of ``AdmissionLimits`` without one.
    """
    allowed = admission or AdmissionLimits()
    entries = {entry["label"]: entry for entry in study.about["entries"]}
    own = [label for label, entry in entries.items() if not entry.get("replay_of")]
    fixed = [label for label in own if not (entries[label].get("trained") or entries[label].get("planned"))]
    fixed = [label for label in fixed if per_30_s(study.of(label)).mean() <= allowed.discomfort_s]
    ends = [label for label in own if entries[label].get("clairvoyant")]
    if not fixed or not ends:
        raise InputError("comparison: lacks a maneuver within comfort, or a clairvoyant planner; allowed: with both")
    best = min(fixed, key=lambda label: float(_log(study, label, "worst_sd").mean()))
    end = min(ends, key=lambda label: float(_log(study, label, "worst_sd").mean()))
    rows = [_row(study, name, group, (best, end), allowed) for name, group in groups(own)]
    return tuple(sorted(rows, key=lambda row: row.figures[0].value))


def markdown(studies: Mapping[str, Results], cost_of: Callable[..., Cost] = cost) -> str:
    """A table for each comparison, by its name, below the command that made it.

    Args:
        studies: comparisons by their names.
        cost_of: tells what an entry costs, as `eval.comparison.cost.cost`.
    """
    parts = ["# Contest", _NOTE]
    for name, study in studies.items():
        rows = [_written(row, cost_of(row.about, study.about["settings"])) for row in contestants(study)]
        table = Table(_HEAD, rows, (0,)).markdown()
        seeds = Settings.from_mapping(study.about["settings"]).seeds
        played = f"{len(seeds)} patients (seeds {seeds[0]}\N{EN DASH}{seeds[-1]})"
        parts += [f"## {name}", made_by(study.about, played), table, *_bound(study)]
    return "\n\n".join(parts) + "\n"


def _bound(study: Results) -> list[str]:
    """A line with the static bound of a few patients, where the twin has their model."""
    import gymnasium as gym

    from agents.static_bound import static_bound

    settings, entries = Settings.from_mapping(study.about["settings"]), study.about["entries"]
    fixed = [entry["label"] for entry in entries if not (entry.get("trained") or entry.get("planned"))]
    fixed = [label for label in fixed if per_30_s(study.of(label)).mean() <= AdmissionLimits().discomfort_s]
    best = min(fixed, key=lambda label: float(_log(study, label, "worst_sd").mean()))
    number = min(_OF_BOUND, settings.patients)
    env: Any = gym.make_vec(settings.world.env_id, number, **settings.world.arguments)
    env.reset(seed=settings.seed)
    try:
        bound = static_bound(env.unwrapped.simulation, settings.world.episode_s).log_worst
    except InputError:  # the twin has the midline model alone, and the bound is of a jaw that is known exactly
        return []
    less = words.with_interval(statistics.mean(bound - _log(study, best, "worst_sd")[:number]), 3)
    return [f"Static bound of the first {number} patients (`agents/static_bound.py`): worst sd {less}."]


def _row(
    study: Results, name: str, group: Sequence[str], scale: tuple[str, str], admission: AdmissionLimits
) -> _Contestant:
    best, end = scale

    def less(column: str, others: Sequence[str]) -> Array:
        return np.array(
            [_log(study, own, column) - _log(study, other, column) for own, other in zip(group, others, strict=True)]
        )

    worst, error = (less(column, [best] * len(group)) for column in ("worst_sd", "rmse"))
    whole = _log(study, end, "worst_sd") - _log(study, best, "worst_sd")
    replays = [replays_of(study, label) for label in group]
    kinds = [list(kind) for kind in zip(*replays, strict=False)]
    against = [_over(less("worst_sd", kind)) for kind in kinds] or [UNKNOWN, UNKNOWN]
    own = FIGURES["discomfort_s"], above_limit(admission.discomfort_s), FIGURES["nees_per_parameter"]
    of_each = [figure.scale * np.array([figure.of(study.of(label)) for label in group]) for figure in own]
    about = next(entry for entry in study.about["entries"] if entry["label"] == group[0])
    closed = words.scaled(statistics.ratio_over_both(worst, whole), 100.0)
    return _Contestant(
        name,
        len(group),
        (*_seconds(study, group), _over(worst), closed, _over(error), *against, *map(_over, of_each)),
        about,
    )


def _seconds(study: Results, group: Sequence[str]) -> list[Interval]:
    """Seconds until sure, those of nine in ten patients, and until all verdicts stand."""
    longest = Settings.from_mapping(study.about["settings"]).world.episode_s
    sure, verdicts = (
        np.array([np.minimum(study.of(label)[column].to_numpy(dtype=np.float64), longest) for label in group])
        for column in (f"time_to_{KNOWN:g}_s", "verdicts_s")
    )
    return [
        _over(sure),
        statistics.quantile(sure.ravel(), 0.9),
        UNKNOWN if np.isnan(verdicts).any() else _over(verdicts),
    ]


def _written(row: _Contestant, cost: Cost) -> list[str]:
    figures = list(map(words.with_interval, row.figures, _DIGITS.values()))
    steps = words.NOTHING if math.isnan(cost.trained_steps) else f"{cost.trained_steps:,.0f}"
    return [words.label(row.name), str(row.seeds), *figures, steps, words.number(cost.decision_ms, 2)]


def _over(values: Array) -> Interval:
    """Mean of (S, N) over patients, and over trainings where there are several."""
    return statistics.mean(values[0]) if len(values) == 1 else statistics.mean_over_both(values)


def _log(study: Results, label: str, column: str) -> Array:
    values: Array = np.log(study.of(label)[column].to_numpy(dtype=np.float64))
    return values
