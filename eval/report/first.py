"""The answer of a study in a sentence, whether it can be believed, and the entries that are named first."""

from __future__ import annotations

import math

from eval.comparison.admission import FALSE_NEES, LARGEST_RINGING
from eval.comparison.ranking import KNOWN, Ranking, RankingRow
from eval.figures import words
from eval.figures.catalogue import reaches, time_to

N_BEST = 5
NEARLY_KNOWN = 0.1
"""The coarser of the two targets of the worst sd that the answer names."""


def firsts(ranking: Ranking) -> tuple[RankingRow, ...]:
    """The best five, and all entries of one's own, in the order of the rows."""
    best = ranking.rows[:N_BEST]
    return tuple(row for row in ranking.rows if row in best or row.own)


def rest(ranking: Ranking) -> tuple[RankingRow, ...]:
    """All other rows."""
    shown = firsts(ranking)
    return tuple(row for row in ranking.rows if row not in shown)


def answer(ranking: Ranking) -> str:
    """One sentence on the best entry, the time until all parameters are known by it, and the patients.

    Before it the effects on the truth unknown to the filter, if any.
    """
    effects = ", ".join(f"{name} = {value:g}" for name, value in ranking.effects.items())
    sentence = f"with {effects}, unknown to the filter: {_answer(ranking)}" if effects else _answer(ranking)
    return sentence[0].upper() + sentence[1:]


def _answer(ranking: Ranking) -> str:
    number, patients = ranking.n_parameters, f"{ranking.patients} patient{'' if ranking.patients == 1 else 's'}"
    best = ranking.best
    if not ranking.believed:
        return f"No maneuver identifies the {number} parameters of these {patients}: the stated precision is false."
    if not ranking.ranked:
        return f"No maneuver can be ranked on these {patients}: the table below says why."
    if best is None:
        ahead = words.label(ranking.ranked[0].entry)
        return f"No maneuver is best on these {patients}: {ahead} is ahead, but its stated errors cannot be believed."
    times = ", ".join(_reached(best, target) for target in (NEARLY_KNOWN, KNOWN))
    which = "the only one ranked" if len(ranking.ranked) == 1 else "the best"
    half = "in the one patient" if ranking.patients == 1 else f"in half of the {patients}"
    return f"{which} is {words.label(best.entry)}: {half}, {ranking.sought} are {times}."


def _reached(row: RankingRow, target: float) -> str:
    """`within 5 % after 9.3 s`, as the median over the patients."""
    to = f"within {100.0 * target:g} %"
    seconds, share = row[time_to(target)].value, row[reaches(target)].value
    if math.isfinite(seconds):
        return f"{to} after {words.number(seconds)} s"
    return f"{to} only in {words.percent(share, 0)} % of all" if share else f"{to} in none"


def belief(ranking: Ranking) -> tuple[bool, str]:
    """Whether the stated precision of the best entry can be believed, and its NEES, the band, and its alarm."""
    row = ranking.best or (ranking.ranked or ranking.rows)[0]
    nees, rings = words.with_interval(row["nees"]), words.percent(row["rings"].value, 0)
    low, high = map(words.number, ranking.band)
    median, most = (words.number(row[name].value) for name in ("known_nees", "known_nees_p90"))
    because = (
        f"the NEES of {words.label(row.entry)} is {nees}, calibrated error bars give {low} to {high}; when "
        f"{ranking.sought} are first within 5 % it is {median} in half of the patients, {most} in nine of ten, "
        f"allowed {words.number(FALSE_NEES * ranking.n_parameters)}; the alarm rings "
        f"in {rings} % of the episodes, allowed are {words.percent(LARGEST_RINGING, 0)} %."
    )
    return ranking.believes(row), because
