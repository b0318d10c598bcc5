"""Whether an entry adapts to its patient: it against its own averaged targets, replayed without looking."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from eval import statistics
from eval.comparison.results import Results
from eval.statistics import Interval


@dataclass(frozen=True)
class Adaptation:
    """An entry against its replay on the same patients and noise.

    Attributes:
        entry: label of the entry.
        replay: label of its replay.
        early: mean difference of the natural log of the worst sd after ``EARLY_S``, below 0 where the entry is better;
            NaN in shorter episodes.
        end: the same at the end.
    """

    entry: str
    replay: str
    early: Interval
    end: Interval

    def verdict(self, difference: Interval) -> str:
        """`adapts` where the whole interval is below 0, `does worse` where it is above, else `not shown`."""
        if not difference.known:
            return "not known"
        if difference.high < 0.0:
            return "adapts"
        return "does worse" if difference.low > 0.0 else "not shown"


def adaptations(study: Results) -> tuple[Adaptation, ...]:
    """Every entry of a study that has a replay, in the order in which they were played."""
    about = study.about.get("entries", [])
    pairs = [(each["replay_of"], each["label"]) for each in about if each.get("replay_of")]
    return tuple(
        Adaptation(
            entry, replay, _difference(study, entry, replay, "early_worst_sd"), _difference(study, entry, replay)
        )
        for entry, replay in pairs
    )


def _difference(study: Results, entry: str, replay: str, column: str = "worst_sd") -> Interval:
    """Mean over the patients of the difference of the logs."""
    own, other = study.of(entry), study.of(replay)
    return statistics.difference(np.log(own[column].to_numpy()), np.log(other[column].to_numpy()))
