"""What the figures of a study say, in plain words."""

from __future__ import annotations

import numpy as np

from eval import words
from eval.comparison.admission import LARGEST_RINGING
from eval.comparison.ranking import GAP_NATS, KNOWN, Ranking, Row


def headline(ranking: Ranking) -> str:
    """Who is best, and what that is worth; before it what the filter did not know, if anything."""
    number = ranking.n_parameters
    what = f"the {number} parameters of {ranking.env}"
    known = f"With {effects(ranking)}, which the filter does not know, " if ranking.effects else ""
    if not ranking.believed:
        least = max(ranking.rows, key=lambda row: row.information_true.value)
        return _sentence(
            f"{known}nothing here identifies {what}: the sds are false. Even {words.label(least.entry)}, the least "
            f"misled, claims {words.number(least.information_claimed.value)} nats and has "
            f"{words.number(least.information_true.value)}."
        )
    if not ranking.ranked:
        return _sentence(f"{known}no entry can be ranked: the table says why.")
    best = ranking.best
    if best is None:
        ahead = words.label(ranking.ranked[0].entry)
        return _sentence(f"{known}no entry is best for {what}: {ahead} is ahead, and its sds are too small: see below.")
    tied = [words.label(row.entry) for row in ranking.ranked[1:] if _tied(row)]
    also = (
        f" In true information it cannot be told from {_list(tied)}." if tied and _is_reference(ranking, best) else ""
    )
    by = f"{known}{what} are identified best by {words.label(best.entry)}."
    return _sentence(f"{by} {_soon(ranking, best)}{also}")


def effects(ranking: Ranking) -> str:
    """`creep_share = 0.3`: what acted on the truth and was unknown to the filter."""
    return ", ".join(f"{name} = {value:g}" for name, value in ranking.effects.items())


def bound_caption(ranking: Ranking) -> str:
    """What the bound in the figures is, and what it means where the truth exceeds it."""
    if ranking.effects or ranking.estimator:
        return "No bound is drawn: it holds for a filter whose model is true."
    caption = (
        "Upright line: the posterior Cramér–Rao bound, the most that an unbiased estimator could learn from that "
        "maneuver, on average over noise and over patients drawn from the filter's prior."
    )
    beyond = [
        words.label(row.entry) for row in ranking.rows if row.information_true.value > row.information_bound.value
    ]
    if beyond:
        caption += (
            f" {_sentence(_list(beyond))} {'lies' if len(beyond) == 1 else 'lie'} beyond it on these patients, as "
            "averages of few may, and where patients lie nearer the prior's mean than the prior says."
        )
    return caption


def _soon(ranking: Ranking, best: Row) -> str:
    """How soon all are known, or how well at the end where few get there."""
    number, share = ranking.n_parameters, best.share_to[KNOWN].value
    late = words.number(best.time_to_p90[KNOWN].value)
    if np.isfinite(best.time_to[KNOWN].value):
        tail = (
            f"in nine of ten within {late} s" if late != "never" else f"in {words.percent(share, 0)} % of them at all"
        )
        seconds = words.number(best.time_to[KNOWN].value)
        return f"In half of the patients all {number} are known to {100 * KNOWN:g} % within {seconds} s, {tail}."
    if share == 0.0:
        reached = f"In no patient do all {number} become known to {100 * KNOWN:g} % within the episode"
    else:
        rate = words.percent(share, 0)
        reached = f"All {number} become known to {100 * KNOWN:g} % in {rate} % of the patients only"
    worst = words.percent(best.worst_sd_median.value)
    return f"{reached}; at the end the worst sd is {worst} % or smaller in half of the patients."


def _is_reference(ranking: Ranking, row: Row) -> bool:
    return row.entry == ranking.reference


def _sentence(text: str) -> str:
    return text[0].upper() + text[1:]


def remarks(ranking: Ranking) -> list[str]:
    """What a reader must know before believing the ranking: agents, honesty, comfort."""
    lines = [_of_agent(ranking, row) for row in ranking.rows if row.trained]
    lines += [f"Not ranked: {words.label(row.entry)}, {row.excluded}." for row in ranking.others]
    lines += _of_honesty(ranking)
    lines += _of_gaps(ranking)
    lines += _of_alarm(ranking)
    lines += _of_comfort(ranking)
    if ranking.patients < 2:
        lines.append("One patient only: there is no interval, and no figure here says anything about other patients.")
    elif ranking.patients < 20:
        lines.append(
            f"Only {ranking.patients} patients: the intervals are rough, and the 90 % quantile rests on one or two."
        )
    return lines


def _tied(row: Row) -> bool:
    """Whether the interval of the difference to the reference holds 0."""
    return row.difference is not None and row.difference.known and row.difference.low <= 0.0 <= row.difference.high


def _of_agent(ranking: Ranking, row: Row) -> str:
    """Where a trained agent stands."""
    place, number = ranking.place(row), len(ranking.ranked)
    name = f"The trained agent {words.label(row.entry)}"
    if len(ranking.rows) == 1:
        return f"{name} was played alone."
    if place is None:
        return f"{name} is not ranked."
    sentence = f"{name} is number {place} of {number}"
    if row.difference is not None:
        ahead = row.difference.value > 0.0
        sentence += (
            f": {words.number(abs(row.difference.value))} nats {'more' if ahead else 'less'} than "
            f"{words.label(ranking.reference)}"
        )
        if row.difference.known:
            chance = "which may be chance" if _tied(row) else "which is not chance"
            digits = 2 if abs(row.difference.value) < 10.0 else 1
            sentence += f" (95 % interval {words.interval(row.difference, digits)}, {chance})"
    ahead_of_it = [words.label(other.entry) for other in ranking.ranked[: place - 1] if not other.trained]
    if ahead_of_it:
        sentence += f". Ahead of it: {_list(ahead_of_it)}"
    return sentence + "."


def _of_honesty(ranking: Ranking) -> list[str]:
    low, high = ranking.band
    groups = {
        kind: [row for row in ranking.rows if ranking.calibration(row) == kind]
        for kind in ("overconfident", "cautious")
    }
    lines = []
    if groups["overconfident"]:
        listed = _list(
            [f"{words.label(row.entry)} ({words.number(row.nees.value)})" for row in groups["overconfident"]]
        )
        lines.append(
            f"Overconfident: {listed}. The mean NEES is above {high:.1f}, so the errors are larger than the sd that "
            "the filter states; read those sd as too small."
        )
    if groups["cautious"]:
        listed = _list([f"{words.label(row.entry)} ({words.number(row.nees.value)})" for row in groups["cautious"]])
        prior = ranking.rows[0].nees_prior
        why = (
            f" The cohort itself is narrower than the filter's prior (NEES {words.number(prior)} before anything is "
            "measured), so a maneuver that teaches little starts and stays there."
            if prior < low
            else ""
        )
        lines.append(f"Too cautious: {listed}. The mean NEES is below {low:.1f}: the truth is nearer than stated.{why}")
    if not lines:
        lines.append(
            f"Every entry is honest: all mean NEES lie within {low:.1f} … {high:.1f}, as in 19 of 20 honest studies."
        )
    return lines


def _of_gaps(ranking: Ranking) -> list[str]:
    """Entries whose claimed and true information are far apart; and what honest ones would show on these patients."""
    found = [row for row in ranking.rows if abs(row.honesty_gap.value) > GAP_NATS]
    if not found:
        return []
    said = [
        f"{words.label(row.entry)} claims {words.number(abs(row.honesty_gap.value))} nats "
        f"{'more' if row.honesty_gap.value > 0.0 else 'less'} than is true"
        for row in found
    ]
    lines = [f"Claimed against true information: {'; '.join(said)}."]
    expected = 0.5 * (ranking.n_parameters - ranking.rows[0].nees_prior)
    if abs(expected) > 0.5 * GAP_NATS:
        lines.append(
            f"Of these gaps {words.number(expected)} nats are the patients': their NEES is "
            f"{words.number(ranking.rows[0].nees_prior)} before anything is measured, where that of patients drawn "
            f"from the filter's prior is {ranking.n_parameters}."
        )
    return lines


def _of_alarm(ranking: Ranking) -> list[str]:
    """In which share of the episodes of whom the alarm rings, and whether honest episodes may ring so often."""

    def listed(rows: list[Row]) -> str:
        return _list([f"{words.label(row.entry)} ({words.percent(row.rings.value)} %)" for row in rows])

    often = [row for row in ranking.rows if row.rings.value > LARGEST_RINGING]
    seldom = [row for row in ranking.rows if 0.0 < row.rings.value <= LARGEST_RINGING]
    lines = []
    if often:
        told = f"The readings do not fit the model, in that share of the episodes, of {listed(often)}"
        lines.append(f"{told}: do not trust their sds.")
    if seldom:
        lines.append(f"The alarm rings in some episodes of {listed(seldom)}, no more than it may where all is honest.")
    return lines


def _of_comfort(ranking: Ranking) -> list[str]:
    crossed = [row for row in ranking.rows if row.violated.value > 0.0]
    if crossed:
        listed = _list([f"{words.label(row.entry)} ({words.percent(row.violated.value)} %)" for row in crossed])
        return [f"A hard comfort limit was crossed, in that share of the episodes, by {listed}."]
    return ["No hard comfort limit was crossed in any episode."]


def _list(items: list[str]) -> str:
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"
