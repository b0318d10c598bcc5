"""What a training has changed: a trained correction beside the maneuver that it corrects, on the same patients."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from agents.card import card_of
from agents.evaluations import read_evaluations
from eval import statistics, words
from eval.comparison.ranking import KNOWN, Ranking, Row
from eval.comparison.results import EARLY_S, Results
from eval.statistics import Interval
from jawenv.controls import takes_targets
from jawenv.errors import InputError

SEEN = 0.05
"""Of the comfortable excursion: a target that moves by less is as good as still."""
_WIDER, _MIDDLE = 1.15, (5, 95)


@dataclass(frozen=True)
class Change:
    """One target before and after, as fractions of the comfortable excursion: the middle 90 % of what was asked for."""

    target: str
    before: tuple[float, float]
    after: tuple[float, float]

    @property
    def said(self) -> str:
        """What has changed, in words."""
        first, then = (0.5 * (high - low) for low, high in (self.before, self.after))
        if max(first, then) < SEEN:
            return "still, as before"
        if first < SEEN:
            return f"new: ± {then:.2f}"
        if then < SEEN:
            return "no longer used"
        wider = then / first
        said = "as wide" if 1.0 / _WIDER < wider < _WIDER else f"{wider:.1f} times as wide"
        moved = 0.5 * (sum(self.after) - sum(self.before))
        return said if abs(moved) < SEEN else f"{said}, on average {abs(moved):.2f} {'more' if moved > 0 else 'less'}"


@dataclass(frozen=True)
class Learned:
    """A trained entry against the maneuver that it corrects.

    Attributes:
        entry: row of the trained entry.
        base: row of the maneuver.
        untrained: the best ranked row that is neither trained nor ``base``.
        steps: environment steps of the training.
        early: mean difference of the natural log of the worst sd after ``EARLY_S``; below 0 the entry is better.
        end: the same at the end.
        changes: of its targets, on the patient whose motion was kept; none where the device follows no targets.
    """

    entry: Row
    base: Row
    untrained: Row | None
    steps: int
    early: Interval
    end: Interval
    changes: tuple[Change, ...]

    @property
    def sooner(self) -> str:
        """How soon all parameters are known, before and after."""
        before, after = (row.time_to[KNOWN].value for row in (self.base, self.entry))
        said = [f"after {words.number(time)} s" if math.isfinite(time) else "never" for time in (before, after)]
        base, entry = words.label(self.base.entry), words.label(self.entry.entry)
        known = f"knows all parameters to {100.0 * KNOWN:g} % {said[0]}"
        return f"{entry} began as {base}. In half of the patients that {known}, {entry} {said[1]}."

    @property
    def verdict(self) -> str:
        """What learning did, and what it did not."""
        base = words.label(self.base.entry)
        when, gain = (f"After {EARLY_S:g} s", self.early) if self.early.known else ("At the end", self.end)
        low, value, high = (f"{100.0 * np.exp(end):.0f}" for end in (gain.low, gain.value, gain.high))
        found = f"{when}, the worst sd is {value} % ({low} … {high}) of that of {base} on the same patient"
        if not gain.known or gain.low <= 0.0 <= gain.high:
            return f"{found}: that learning changed anything is not shown."
        if gain.low > 0.0:
            return f"{found}: learning made it worse."
        said = f"{found}: that is what learning did."
        if self.untrained is None:
            return said
        ahead = self.untrained.worst_sd_median.value < self.entry.worst_sd_median.value
        other = words.label(self.untrained.entry).capitalize()
        return f"{said} {other}, which no training made, is {'still ahead of it' if ahead else 'behind it'}."


def learned(study: Results, ranking: Ranking) -> tuple[Learned, ...]:
    """Every trained entry whose run lies where it was, and which corrects a maneuver of the same study."""
    rows = {row.entry: row for row in ranking.rows}
    found = []
    for each in study.about.get("entries", []):
        corrected = _corrected(Path(each["spec"])) if each.get("trained") and each["label"] in rows else None
        if corrected is None or corrected[0] not in rows:
            continue
        entry, base = rows[each["label"]], rows[corrected[0]]
        untrained = [row for row in ranking.ranked if not row.trained and row is not base]
        found.append(
            Learned(
                entry,
                base,
                untrained[0] if untrained else None,
                corrected[1],
                _difference(study, entry, base, "early_worst_sd"),
                _difference(study, entry, base, "worst_sd"),
                _changes(study.motions.get(base.entry), study.motions.get(entry.entry), study.about),
            )
        )
    return tuple(found)


def _corrected(folder: Path) -> tuple[str, int] | None:
    """The maneuver that a run's policy corrects, and the run's steps so far."""
    try:
        card, table = card_of(folder), read_evaluations(folder)
    except InputError:
        return None
    residual = None if card is None else card[1].residual
    return None if residual is None or not table else (residual.maneuver.name, int(table[-1]["steps"]))


def _difference(study: Results, entry: Row, base: Row, column: str) -> Interval:
    own, other = (study.of(row.entry)[column].to_numpy() for row in (entry, base))
    return statistics.difference(np.log(own), np.log(other))


def _changes(before: dict[str, Any] | None, after: dict[str, Any] | None, about: dict[str, Any]) -> tuple[Change, ...]:
    from jawenv.playing.maneuvers.player import goals_of

    if not before or not after or not takes_targets(about["settings"]["control"]):
        return ()
    ranges = [np.percentile(goals_of(np.array(each["frames"]["command"])), _MIDDLE, axis=0) for each in (before, after)]
    first, then = (np.round(each, 2).T.tolist() for each in ranges)
    return tuple(
        Change(name, (one[0], one[1]), (two[0], two[1]))
        for name, one, two in zip(after["commands"], first, then, strict=True)
    )
