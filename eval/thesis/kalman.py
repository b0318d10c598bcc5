"""Figs. 6.9 to 6.11 and the noise on the parameters: the extended Kalman filter on a jaw that is driven by force."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import pandas as pd

from agents import load_agent
from eval.figures import statistics
from eval.figures.statistics import Interval
from eval.thesis import rows
from eval.thesis.item import NO_NUMBER, Draw, Item, Judgement, judged
from jawenv.playing.rollout import play
from jawenv.recordings.record import Record
from jawenv.references.extended_kalman import ExtendedKalman

MANEUVER = "opening_with_swings_and_fore_aft"
EPISODE_S = 30.0
TIMES = 41
KNOWN = 0.1  # sd of a parameter that is known: 10 %
THREE_SIGMA = 0.9973  # of a normal distribution

THESIS = ExtendedKalman("linear", parameter_rate=0.01, parameter_time=math.inf)
OURS = ExtendedKalman("log")
_UNKNOWNS = {"linear": "F_o and b", "log": "their logs"}
NOISES = {
    "none, F_o and b": ExtendedKalman("linear", parameter_rate=0.0, parameter_time=math.inf),
    "constant, F_o and b": THESIS,
    "none, logs": ExtendedKalman("log", parameter_rate=0.0),
    "decaying, logs": OURS,
}


def episodes(model: str, cohort: str, rngs: Sequence[np.random.Generator]) -> list[Record]:
    """Recordings of new patients under the reference maneuver, force control, played side by side.

    Each takes its seed from its own random numbers, and is the same whoever is beside it.
    """
    env_id = {"sides": "jawenv/JawSides-v3", "jaw": "jawenv/Jaw-v3"}[model]
    recording = play(
        load_agent(MANEUVER, control="force", env_id=env_id),
        patients=len(rngs),
        seed=[int(rng.integers(2**31)) for rng in rngs],
        env_kwargs={"cohort": cohort, "episode_s": EPISODE_S, "record": True, "track_bound": False},
        env_id=env_id,
    )
    ends = recording.time[recording.last]
    return [record.until(float(end)) for record, end in zip(recording.records or (), ends, strict=True)]


def _drawn(*groups: tuple[str, str, Mapping[str, ExtendedKalman]]) -> Draw:
    """An item's ``draw``: estimates over time of new patients; a group is a model, a cohort and its filters by case."""

    def draw(rngs: Sequence[np.random.Generator]) -> Iterator[pd.DataFrame]:
        played = [episodes(model, cohort, rngs) for model, cohort, _ in groups]
        for records in zip(*played, strict=True):
            yield pd.concat(
                rows.of_estimate(estimator.estimate(record), record, case, TIMES)
                for record, (_, _, filters) in zip(records, groups, strict=True)
                for case, estimator in filters.items()
            )

    return draw


def _inside(table: pd.DataFrame, sigmas: float) -> pd.Series:
    return (table["estimate"] - table["truth"]).abs() <= sigmas * table["sd"]


def judge_sides(table: pd.DataFrame) -> Judgement:
    """Converging: sds fall; accurate: errors within 3 sigma at the end of nearly all draws."""
    figures: dict[str, Interval] = {}
    known, good = {}, {}
    for case, unknown in _UNKNOWNS.items():
        end = rows.last(rows.of_case(table, case))
        inside, error = statistics.share(_inside(end, 3.0).groupby(end["draw"]).all().to_numpy()), rows.rmse(end)
        figures |= {
            f"error of {unknown}, %": rows.percent(error),
            f"worst sd of {unknown}, %": rows.percent(rows.over_draws(end, "sd")),
            f"all within 3σ of {unknown}, %": rows.percent(inside),
            f"median NEES of {unknown} (calibrated: 3.4)": rows.over_draws(end, "nees"),
        }
        known[case] = error.value < KNOWN
        good[case] = known[case] and inside.high >= THREE_SIGMA**4
    return judged(good["linear"], good["log"] or known["linear"], figures)


def _time_to_known(table: pd.DataFrame, case: str) -> np.ndarray:
    """Seconds in each draw until the median parameter's sd is 10 %; infinite where it is never."""
    rows_of_case = rows.of_case(table, case)
    median = rows_of_case.groupby(["draw", "time_s"])["sd"].median().reset_index()
    reached = median[median["sd"] <= KNOWN].groupby("draw")["time_s"].min()
    return reached.reindex(sorted(set(table["draw"])), fill_value=np.inf).to_numpy()


def judge_full(table: pd.DataFrame) -> Judgement:
    """Tracking is possible, slower than with two sides."""
    end = rows.last(table)
    error = {case: rows.rmse(rows.of_case(end, case)) for case in ("linear", "log")}
    slow = statistics.quantile(_time_to_known(table, "log"), 0.5)
    fast = statistics.quantile(_time_to_known(table, "two sides"), 0.5)
    prior = float(rows.of_case(table, "log").groupby("draw")["sd"].max().median())
    tracked, slower = error["log"].value < 0.5 * prior, slow.value > fast.value
    figures = {f"error of {unknown}, %": rows.percent(error[case]) for case, unknown in _UNKNOWNS.items()} | {
        "half of the 12 within 10 % after, s": slow,
        "half of the four within 10 % after, s": fast,
    }
    return judged(tracked and slower, tracked or slower, figures)


def judge_noise(table: pd.DataFrame) -> Judgement:
    """Judge whether the filter is further off without noise on the parameters than with it."""
    end = rows.last(table)
    error = {case: rows.rmse(rows.of_case(end, case)) for case in NOISES}
    nees = {case: rows.over_draws(rows.of_case(end, case), "nees") for case in NOISES}
    prior = float(table.groupby("draw")["sd"].max().median())
    without, with_noise = error["none, F_o and b"], error["constant, F_o and b"]
    worse = without.low > with_noise.high
    overconfident = nees["none, F_o and b"].low > nees["constant, F_o and b"].high
    figures = {f"error, noise {case}, %": rows.percent(error[case]) for case in NOISES}
    figures |= {f"median NEES, noise {case} (calibrated: 11.3)": nees[case] for case in NOISES}
    return judged(without.value > 0.5 * prior and worse, worse or overconfident, figures)


_SETTING = (
    f"A new patient in each draw, maneuver “{MANEUVER.replace('_', ' ')}” under force control, {EPISODE_S:g} s, "
    "unmodelled forces and sensor noise of our device."
)

SIDES = Item(
    "ekf_sides",
    "Two sides by extended Kalman filter",
    "Figs. 6.9, 6.10; section 6.5.1",
    f"Four parameters, one F_o and b for each side: “converging and accurate results”, errors within 3σ. {NO_NUMBER}",
    _SETTING + " Cohort “one sided”.",
    _drawn(("sides", "one_sided", {"linear": THESIS, "log": OURS})),
    judge_sides,
)
FULL = Item(
    "ekf_full",
    "12 parameters by extended Kalman filter",
    "Fig. 6.11; section 6.5.2",
    "“It is possible to track the 12 muscle parameters”; it “does not converge as quickly” as with two sides. "
    f"{NO_NUMBER}",
    _SETTING + " Cohort “trismus”.",
    _drawn(("jaw", "trismus", {"linear": THESIS, "log": OURS}), ("sides", "trismus", {"two sides": OURS})),
    judge_full,
)
NOISE = Item(
    "ekf_noise",
    "Noise on the constant parameters",
    "Sections 6.5, 7.2",
    f"“The Kalman filter does not converge without noise injection” onto the constant parameters. {NO_NUMBER}",
    _SETTING + " Noise: none; 1 % per √s, constant; and 3 % per √s, decaying in 5 s.",
    _drawn(("jaw", "trismus", NOISES)),
    judge_noise,
)
