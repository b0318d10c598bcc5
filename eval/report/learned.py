"""Effect of a training: a trained correction beside the maneuver that it corrects, and the evaluations of its run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from eval.comparison.ranking import KNOWN, SOON, Ranking, RankingRow
from eval.comparison.results import Results
from eval.comparison.trainings import difference
from eval.figures import statistics, words
from eval.figures.statistics import Interval
from eval.rows.outcomes import EARLY_S
from jawenv.base.errors import InputError
from jawenv.controls import takes_targets
from jawenv.playing.policies.card import card_of

if TYPE_CHECKING:
    from agents.evaluations import Table

_MIDDLE = (5, 95)


@dataclass(frozen=True)
class _TargetShift:
    """Middle 90 % of one target before and after, as fractions of the comfortable excursion."""

    target: str
    before: tuple[float, float]
    after: tuple[float, float]


@dataclass(frozen=True)
class Learned:
    """A trained entry against the maneuver that it corrects."""

    entry: RankingRow  # row of the trained entry
    base: RankingRow  # row of the maneuver
    steps: int  # environment steps of the training
    early: Interval  # mean difference of the natural log of the worst sd after ``EARLY_S``; below 0 the entry is better
    end: Interval  # the same at the end
    changes: tuple[_TargetShift, ...]
    """Of its targets, on the patient with a kept motion; none where the device follows no targets."""

    @property
    def sooner(self) -> str:
        """Times until all parameters are known, before and after."""
        before, after = (row[SOON].value for row in (self.base, self.entry))
        times = [f"after {words.number(time)} s" if math.isfinite(time) else "never" for time in (before, after)]
        base, entry = words.label(self.base.entry), words.label(self.entry.entry)
        known = f"In half of the patients all parameters are within {100.0 * KNOWN:g} %"
        return f"{entry} began as {base}. {known}: with {base} {times[0]}, with {entry} {times[1]}."

    @property
    def gain(self) -> tuple[str, Interval]:
        """The moment, and the worst sd then as a share of the base's on the same patient."""
        when, log = (f"after {EARLY_S:g} s", self.early) if self.early.known else ("at the end", self.end)
        return when, Interval(*(math.exp(end) for end in (log.value, log.low, log.high)))


@dataclass(frozen=True)
class Learning:
    """Findings of trainings, as far as their runs are still in place."""

    lessons: tuple[Learned, ...]  # of each that corrects a maneuver of the same study
    evaluations: Mapping[int, Table]  # by the number of the row
    notes: list[str]  # on runs that cannot be read


def learned(study: Results, ranking: Ranking) -> Learning:
    """Read the runs of the trained entries, and hold these against the maneuvers that they correct."""
    rows = {row.entry: row for row in ranking.rows}
    lessons = []
    for played in study.about.get("entries", []):
        corrected = _corrected(Path(played["spec"])) if played.get("trained") and played["label"] in rows else None
        if corrected is None or corrected[0] not in rows:
            continue
        entry, base = rows[played["label"]], rows[corrected[0]]
        lessons.append(
            Learned(
                entry,
                base,
                corrected[1],
                statistics.mean(difference(study, "early_worst_sd", entry.entry, base.entry)),
                statistics.mean(difference(study, "worst_sd", entry.entry, base.entry)),
                _changes(study.motions.get(base.entry), study.motions.get(entry.entry), study.about),
            )
        )
    return Learning(tuple(lessons), *_evaluations(study, ranking))


def _corrected(folder: Path) -> tuple[str, int] | None:
    """The maneuver that a run's policy corrects, and the run's steps so far."""
    from agents.evaluations import read_evaluations

    try:
        card, table = card_of(folder), read_evaluations(folder)
    except InputError:
        return None
    residual = None if card is None else card[1].residual
    return None if residual is None or not table else (residual.maneuver.name, int(table[-1]["steps"]))


def _changes(
    before: dict[str, Any] | None, after: dict[str, Any] | None, metadata: dict[str, Any]
) -> tuple[_TargetShift, ...]:
    from jawenv.playing.maneuvers.maneuver import goals_of

    if not before or not after or not takes_targets(metadata["settings"]["control"]):
        return ()
    ranges = [
        np.percentile(goals_of(np.array(motion["frames"]["command"])), _MIDDLE, axis=0) for motion in (before, after)
    ]
    first, then = (np.round(ends, 2).T.tolist() for ends in ranges)
    return tuple(
        _TargetShift(name, (one[0], one[1]), (two[0], two[1]))
        for name, one, two in zip(after["commands"], first, then, strict=True)
    )


def _evaluations(study: Results, ranking: Ranking) -> tuple[dict[int, Table], list[str]]:
    """Evaluations by the number of the row, and notes on runs that cannot be read."""
    specs = {entry["label"]: entry["spec"] for entry in study.about.get("entries", []) if entry.get("trained")}
    by_row: dict[int, Table] = {}
    notes: list[str] = []
    if not specs:
        return by_row, notes
    from agents.evaluations import read_evaluations

    for i, row in enumerate(ranking.rows):
        if row.entry not in specs or not Path(specs[row.entry]).is_dir():
            continue
        try:
            table = read_evaluations(Path(specs[row.entry]))
        except InputError as error:
            notes.append(str(error))
            continue
        if table:
            by_row[i] = table
    return by_row, notes
