"""Effect of a training: a trained correction beside the maneuver that it corrects."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from eval.comparison.ranking import KNOWN, SOON, Ranking, RankingRow
from eval.comparison.results import Results
from eval.comparison.trainings import difference
from eval.figures import statistics, words
from eval.figures.statistics import Interval
from eval.rows.outcomes import EARLY_S
from jawenv.base.errors import InputError
from jawenv.playing.policies.card import card_of


@dataclass(frozen=True)
class Learned:
    """A trained entry against the maneuver that it corrects."""

    entry: RankingRow  # row of the trained entry
    base: RankingRow  # row of the maneuver
    steps: int  # environment steps of the training
    early: Interval  # mean difference of the natural log of the worst sd after ``EARLY_S``; below 0 the entry is better
    end: Interval  # the same at the end

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


def learned(study: Results, ranking: Ranking) -> tuple[Learned, ...]:
    """The trained entries whose runs are still in place, against the maneuvers of the study that they correct."""
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
            )
        )
    return tuple(lessons)


def _corrected(folder: Path) -> tuple[str, int] | None:
    """The maneuver that a run's policy corrects, and the run's steps so far."""
    from agents.evaluations import read_evaluations

    try:
        card, table = card_of(folder), read_evaluations(folder)
    except InputError:
        return None
    residual = None if card is None else card[1].residual
    return None if residual is None or not table else (residual.maneuver.name, int(table[-1]["steps"]))
