"""What the figures of a study say, in plain words."""

from __future__ import annotations

from eval.comparison.ranking import Ranking, Row
from eval.report import words


def headline(ranking: Ranking) -> str:
    """Who is best, and what that is worth."""
    best, number = ranking.rows[0], ranking.n_parameters
    tail = (
        f"In half of the patients the worst of its {number} sd is {words.percent(best.worst_sd_median.value)} % or "
        f"smaller, in nine of ten {words.percent(best.worst_sd_p90.value)} %"
    )
    tail += ", but these sd are too small: see below." if ranking.calibration(best) == "overconfident" else "."
    tied = [words.label(row.entry) for row in ranking.rows[1:] if _tied(row)] if ranking.reference == best.entry else []
    also = f" Not distinguishable from it on these patients: {_list(tied)}." if tied else ""
    what = f"The {number} parameters of {ranking.env}"
    return f"{what} are identified best by {words.label(best.entry)}. {tail}{also}"


def remarks(ranking: Ranking) -> list[str]:
    """What a reader must know before believing the ranking: agents, honesty, comfort."""
    lines = [_of_agent(ranking, row) for row in ranking.rows if row.trained]
    lines += _of_honesty(ranking)
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
    place, number = ranking.rows.index(row) + 1, len(ranking.rows)
    name = f"The trained agent {words.label(row.entry)}"
    if number == 1:
        return f"{name} was played alone."
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
    ahead_of_it = [words.label(other.entry) for other in ranking.rows[: place - 1] if not other.trained]
    if ahead_of_it:
        sentence += f". Ahead of it: {_list(ahead_of_it)}"
    below = [other for other in ranking.rows[place:] if not other.trained]
    clear = [words.label(other.entry) for other in below if not row.information_true.overlaps(other.information_true)]
    if clear:
        sentence += f". Its interval lies wholly above that of {_list(clear)}"
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
        lines.append(f"Every entry is honest: all mean NEES lie within {low:.1f} … {high:.1f}.")
    claimed = max(ranking.rows, key=lambda row: row.information_claimed.value)
    if claimed is not ranking.rows[0]:
        lines.append(
            f"By what the filter claims, {words.label(claimed.entry)} would be first; by the truth it is number "
            f"{ranking.rows.index(claimed) + 1}."
        )
    return lines


def _of_comfort(ranking: Ranking) -> list[str]:
    crossed = [row for row in ranking.rows if row.violated.value > 0.0]
    if crossed:
        listed = _list([f"{words.label(row.entry)} ({words.percent(row.violated.value)} %)" for row in crossed])
        return [f"A hard comfort limit was crossed, in that share of the episodes, by {listed}."]
    return ["No hard comfort limit was crossed in any episode."]


def _list(items: list[str]) -> str:
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"
