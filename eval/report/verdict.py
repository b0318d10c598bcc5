"""What a reader must know before believing a ranking, where no table says it."""

from __future__ import annotations

from eval import words
from eval.comparison.admission import LARGEST_RINGING
from eval.comparison.ranking import Ranking, Row
from eval.report import first


def headline(ranking: Ranking) -> str:
    """The answer; before it what acted on the truth and the filter did not know, if anything."""
    known = f"With {effects(ranking)}, which the filter does not know: " if ranking.effects else ""
    said = known + first.answer(ranking)
    return said[0].upper() + said[1:]


def effects(ranking: Ranking) -> str:
    """`creep_share = 0.3`: what acted on the truth and was unknown to the filter."""
    return ", ".join(f"{name} = {value:g}" for name, value in ranking.effects.items())


def bound_caption(ranking: Ranking) -> str:
    """What the bound in the figures is."""
    if ranking.effects or ranking.estimator:
        return "No bound is drawn: it holds for a filter whose model is true."
    return (
        "Upright line: the posterior Cramér–Rao bound, the most that an unbiased estimator could learn from that "
        "maneuver, on average over noise and over patients drawn from the filter's prior; averages over few patients "
        "may lie beyond it."
    )


def remarks(ranking: Ranking) -> list[str]:
    """Who is not ranked and why, whose sds are false, and how few patients there are."""
    low, high = ranking.band
    lines = [f"Not ranked: {words.label(row.entry)}, {row.excluded}." for row in ranking.others]
    kinds = {row.entry: ranking.calibration(row) for row in ranking.rows}
    large = [row for row in ranking.rows if kinds[row.entry] == "overconfident"]
    small = [row for row in ranking.rows if kinds[row.entry] == "cautious"]
    if large:
        lines.append(f"Overconfident, mean NEES above {high:.1f}: {_listed(large)}; read those sds as too small.")
    if small:
        prior = words.number(ranking.rows[0].nees_prior)
        why = f"; before anything is measured it is {prior}" if ranking.rows[0].nees_prior < low else ""
        lines.append(f"Too cautious, mean NEES below {low:.1f}: {_listed(small)}{why}.")
    if not (large or small):
        lines.append(f"Every entry is honest: all mean NEES lie within {low:.1f} … {high:.1f}.")
    if often := [row for row in ranking.rows if row.rings.value > LARGEST_RINGING]:
        names = ", ".join(f"{words.label(row.entry)} ({words.percent(row.rings.value)} %)" for row in often)
        lines.append(f"The alarm rings too often: {names}; do not trust their sds.")
    if ranking.patients < 20:
        rough = "there is no interval" if ranking.patients < 2 else "the intervals are rough"
        lines.append(f"Patients: {ranking.patients}; {rough}.")
    return lines


def _listed(rows: list[Row]) -> str:
    return ", ".join(f"{words.label(row.entry)} ({words.number(row.nees.value)})" for row in rows)
