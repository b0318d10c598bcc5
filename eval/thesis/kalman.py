"""Figs. 6.9 to 6.11 and the noise on the parameters: the extended Kalman filter on a jaw that is driven by force."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from agents import load_agent
from eval.figures import statistics, words
from eval.thesis import rows
from eval.thesis.item import NO_NUMBER, Item, Judgement, Verdict
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
_TOLD = {"linear": "F_o and b themselves (thesis)", "log": "their logs"}
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


def _draw_sides(rngs: Sequence[np.random.Generator]) -> Iterator[pd.DataFrame]:
    """Four parameters, by the filter of the thesis and by ours, over time."""
    for record in episodes("sides", "one_sided", rngs):
        yield pd.concat(
            [
                rows.of_estimate(f.estimate(record), record, case, TIMES)
                for case, f in (("linear", THESIS), ("log", OURS))
            ]
        )


def _inside(table: pd.DataFrame, sigmas: float) -> pd.Series:
    return (table["estimate"] - table["truth"]).abs() <= sigmas * table["sd"]


def judge_sides(table: pd.DataFrame) -> Judgement:
    """Converging: sds fall; accurate: errors within 3 sigma at the end of nearly all draws."""
    sentences: list[str] = []
    numbers: dict[str, float] = {}
    verdicts: dict[str, bool] = {}
    for case in ("linear", "log"):
        end = rows.last(rows.of_case(table, case))
        inside = statistics.share(_inside(end, 3.0).groupby(end["draw"]).all().to_numpy())
        error, sd = rows.rmse(end), statistics.quantile(end.groupby("draw")["sd"].max().fillna(np.inf).to_numpy(), 0.5)
        nees = statistics.quantile(end.groupby("draw")["nees"].first().fillna(np.inf).to_numpy(), 0.5)
        sentences.append(
            f"{_TOLD[case]}: error {rows.with_interval(error)}, "
            f"worst sd {words.percent(sd.value)} %, all four within 3σ in {rows.with_interval(inside)} of the draws, "
            f"median NEES {words.number(nees.value)} (calibrated: 3.4)"
        )
        numbers |= {f"rmse/{case}": error.value, f"inside_3_sigma/{case}": inside.value, f"worst_sd/{case}": sd.value}
        verdicts[case] = error.value < KNOWN and inside.high >= THREE_SIGMA**4
    good = verdicts["linear"] or verdicts["log"]
    verdict: Verdict = (
        "reproduced" if verdicts["linear"] else "partly" if good or numbers["rmse/linear"] < KNOWN else "not reproduced"
    )
    return Judgement(
        "Estimated as " + "; as ".join(sentences) + ".",
        verdict,
        f"Converges to within {words.percent(KNOWN, 0)} %"
        + (
            " and stays within 3σ."
            if verdicts["linear"]
            else "; as F_o and b themselves the errors leave 3σ too often."
            if numbers["rmse/linear"] < KNOWN
            else " in logs only."
            if verdicts["log"]
            else ": not so."
        ),
        numbers,
    )


def _draw_full(rngs: Sequence[np.random.Generator]) -> Iterator[pd.DataFrame]:
    """Twelve parameters and, for the speed, four, over time."""
    jaws, sides = episodes("jaw", "trismus", rngs), episodes("sides", "trismus", rngs)
    for jaw, side in zip(jaws, sides, strict=True):
        yield pd.concat(
            [
                rows.of_estimate(THESIS.estimate(jaw), jaw, "linear", TIMES),
                rows.of_estimate(OURS.estimate(jaw), jaw, "log", TIMES),
                rows.of_estimate(OURS.estimate(side), side, "two sides", TIMES),
            ]
        )


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
    spacing = float(np.diff(np.unique(rows.of_case(table, "log")["time_s"])).max())
    tracked, slower = error["log"].value < 0.5 * prior, slow.value > fast.value
    return Judgement(
        f"Median error of the 12 parameters after the maneuver: {rows.with_interval(error['linear'])} as F_o and b "
        f"themselves, {rows.with_interval(error['log'])} in logs. Half of the parameters are within 10 % after "
        f"{rows.with_interval(slow, 1.0, ' s')}, of the two-sided model's four after "
        f"{rows.with_interval(fast, 1.0, ' s')} (looked at every {words.number(spacing, 2)} s).",
        "reproduced" if tracked and slower else "partly" if tracked or slower else "not reproduced",
        ("Twelve are tracked" if tracked else "Twelve are not tracked")
        + (", more slowly than four." if slower else ", not more slowly than four."),
        {
            "rmse/linear": error["linear"].value,
            "rmse/log": error["log"].value,
            "slow_s": slow.value,
            "fast_s": fast.value,
        },
    )


def _draw_noise(rngs: Sequence[np.random.Generator]) -> Iterator[pd.DataFrame]:
    """Twelve parameters with and without noise on them."""
    for record in episodes("jaw", "trismus", rngs):
        yield pd.concat([rows.of_estimate(f.estimate(record), record, case, TIMES) for case, f in NOISES.items()])


def judge_noise(table: pd.DataFrame) -> Judgement:
    """Judge whether the filter is further off without noise on the parameters than with it."""
    end = rows.last(table)
    error = {case: rows.rmse(rows.of_case(end, case)) for case in NOISES}
    nees = {
        case: statistics.quantile(
            rows.of_case(end, case).groupby("draw")["nees"].first().fillna(np.inf).to_numpy(), 0.5
        )
        for case in NOISES
    }
    prior = float(table.groupby("draw")["sd"].max().median())
    without, with_noise = error["none, F_o and b"], error["constant, F_o and b"]
    fails = without.value > 0.5 * prior
    worse = without.low > with_noise.high
    listed = "; ".join(
        f"{case}: error {rows.with_interval(error[case])}, median NEES {words.number(nees[case].value)}"
        for case in NOISES
    )
    overconfident = nees["none, F_o and b"].low > nees["constant, F_o and b"].high
    return Judgement(
        f"Noise on the parameters {listed} (calibrated: 11.3).",
        "reproduced" if fails and worse else "partly" if worse or overconfident else "not reproduced",
        ("Without noise it does not converge" if fails else "Without noise it does converge")
        + (", and is further off." if worse else ", but claims too much." if overconfident else " and is no worse."),
        {f"rmse/{case}": error[case].value for case in NOISES} | {f"nees/{case}": nees[case].value for case in NOISES},
    )


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
    _draw_sides,
    judge_sides,
)
FULL = Item(
    "ekf_full",
    "12 parameters by extended Kalman filter",
    "Fig. 6.11; section 6.5.2",
    "“It is possible to track the 12 muscle parameters”; it “does not converge as quickly” as with two sides. "
    f"{NO_NUMBER}",
    _SETTING + " Cohort “trismus”.",
    _draw_full,
    judge_full,
)
NOISE = Item(
    "ekf_noise",
    "Noise on the constant parameters",
    "Sections 6.5, 7.2",
    f"“The Kalman filter does not converge without noise injection” onto the constant parameters. {NO_NUMBER}",
    _SETTING + " Noise: none; 1 % per √s, constant; and 3 % per √s, decaying in 5 s.",
    _draw_noise,
    judge_noise,
)
