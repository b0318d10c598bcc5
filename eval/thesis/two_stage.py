"""Appendix A.4: the method that failed, and why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from eval import drawing, words
from eval.thesis import rows
from eval.thesis.item import NO_NUMBER, Finding, Item
from eval.thesis.prescribed import with_noise
from eval.thesis.settings import SENSORS, hinge_record, plane_record
from jawenv.estimation.least_squares import NonlinearLeastSquares
from jawenv.estimation.record import Record
from jawenv.estimation.two_stage import TwoStageLogLinear

CLOSE = 0.1
PURE = "without noise"
RECORDS = {"one muscle": hinge_record, "three muscles": plane_record}
METHODS = {"two stages": TwoStageLogLinear(), "nonlinear": NonlinearLeastSquares(starts=1)}


def draw(rng: np.random.Generator, quick: bool) -> pd.DataFrame:
    """One muscle on a hinge and three in the plane, by the two-stage method and by nonlinear least squares."""
    del quick
    found = []
    for muscles, clean in RECORDS.items():
        record = with_noise(clean(), SENSORS, rng)
        for method, estimator in METHODS.items():
            found.append(rows.of_estimate(estimator.estimate(record), record, f"{muscles}, {method}"))
        found.append(rows.of_estimate(METHODS["two stages"].estimate(_pure(clean())), clean(), f"{muscles}, {PURE}"))
    return pd.concat(found)


def _pure(record: Record) -> Record:
    """The noise-free record: what is wrong then is the method's own."""
    return replace(record, gain_sd=0.0)


def relative_error(table: pd.DataFrame, case: str, symbol: str) -> float:
    """Median over draws and muscles of |estimate / truth - 1|; infinite where most have no value."""
    one = rows.kind(rows.of_case(table, case), symbol)
    error = (one["value"] / one["true_value"] - 1.0).abs().fillna(np.inf)
    return float(np.median(error))


def judge(table: pd.DataFrame) -> Finding:
    """Fails with several muscles, with noise and without; works with one."""
    numbers = {
        f"{symbol}/{case}": relative_error(table, case, f"log_{symbol}")
        for case in dict.fromkeys(table["case"])
        for symbol in ("F_o", "b")
    }
    fails = numbers["b/three muscles, two stages"] > CLOSE
    by_itself = numbers[f"b/three muscles, {PURE}"] > CLOSE
    single = numbers[f"b/one muscle, {PURE}"]
    other = numbers["b/three muscles, nonlinear"]

    def told(value: float) -> str:
        return "no value in most draws" if not np.isfinite(value) else f"{words.percent(value)} %"

    return Finding(
        f"Three muscles, median error of b: {told(numbers['b/three muscles, two stages'])}; without any noise "
        f"{told(numbers[f'b/three muscles, {PURE}'])}; nonlinear least squares on the same data {told(other)}. One "
        "muscle: "
        f"{told(numbers['b/one muscle, two stages'])}, without noise {told(single)} (F_o "
        f"{told(numbers[f'F_o/one muscle, {PURE}'])}).",
        "reproduced" if fails else "not reproduced",
        ("It fails" if fails else "It does not fail")
        + (
            ", and not for noise: the logarithm of a sum is taken for the sum of logarithms (A.38–A.40)"
            if by_itself
            else ", with noise only"
        )
        + (
            ", and with one muscle, of which there is no sum, it is far better."
            if single < 0.5 * numbers[f"b/three muscles, {PURE}"]
            else ", and with one muscle it is no better: F_o taken as constant in the first stage adds to it."
        ),
        {name: value for name, value in numbers.items() if np.isfinite(value)},
    )


def figure(table: pd.DataFrame) -> Figure:
    """Estimates of b over the truth, per case."""
    cases = list(dict.fromkeys(table["case"]))
    with drawing.style():
        drawn = Figure(figsize=(8.6, 0.6 + 0.42 * len(cases)), layout="constrained")
        for axes, symbol, title in zip(
            drawn.subplots(1, 2, sharey=True), ("log_F_o", "log_b"), ("F_o", "b"), strict=True
        ):
            for place, case in enumerate(cases):
                one = rows.kind(rows.of_case(table, case), symbol)
                ratio = (one["value"] / one["true_value"]).to_numpy()
                ratio = ratio[np.isfinite(ratio)]
                offsets = place + 0.32 * np.linspace(-1, 1, len(ratio)) if len(ratio) else []
                axes.scatter(np.clip(ratio, 0.02, 50), offsets, s=6, color="#3b82c4", alpha=0.5, linewidth=0)
            axes.axvline(1.0, color="#c25b4e", linewidth=1.4)
            axes.set_xscale("log")
            axes.set(title=f"{title}: estimate / truth", ylim=(len(cases) - 0.5, -0.5), yticks=range(len(cases)))
            axes.set_yticklabels(cases)
            axes.grid(axis="y", visible=False)
        return drawn


ITEM = Item(
    "two_stage",
    "The failed two-stage method",
    "Appendix A.4",
    "F_o from small openings, where the force is taken as constant, then b from the logarithm of the moment: a “failed "
    f"method”. Why it failed is not said. {NO_NUMBER}",
    "One muscle on a hinge, and the three of Fig. 6.4 in the plane; both stages from one recording to 25°.",
    draw,
    judge,
    figure,
    "One dot per draw and muscle, spread for sight; no dot where an estimate has no logarithm.",
)
