"""Every entry's figures with their intervals, the best first."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from eval import statistics
from eval.comparison.results import Results
from eval.statistics import Interval
from jawenv.errors import InputError
from jawenv.metrics import BLOCKED_B, FIBROSED_F_O_N, Diagnosis, diagnose, nees_band, whole_muscles_per_line

SIGMAS = {1: 0.6827, 2: 0.9545, 3: 0.9973}
"""Share of a Gaussian within so many standard deviations of its mean."""
_TIME_TO = re.compile(r"time_to_(.+)_s")


@dataclass(frozen=True)
class Row:
    """One entry; means over the patients unless said otherwise, sd of natural logs, information in nats.

    Attributes:
        entry: its label.
        trained: whether it comes from a training run.
        control: its control mode.
        note: in which settings it differs from those asked for.
        description: what it does.
        information_true: by the log score; the ranking goes by this.
        information_claimed: by the covariance.
        information_bound: by the posterior Cramer-Rao bound.
        honesty_gap: claimed minus true.
        difference: true information minus the reference's, patient by patient; None for the reference itself.
        worst_sd_median: median over the patients of the worst sd of all parameters.
        worst_sd_p90: its 90 % quantile.
        worst_sd_max: its maximum.
        identified: number of parameters known.
        rmse_over_bound: error as a multiple of the bound.
        nees: the number of parameters if honest.
        nees_prior: the same of the prior, before anything was measured.
        inside: sigmas -> share of the truths within so many claimed standard deviations.
        share_to: target of the worst sd -> share of the patients that reach it.
        time_to: target -> median time, s, those who never reach it counted as infinitely late.
        discomfort_s: integral of the cost.
        largest_fraction: largest used fraction of a soft limit in any patient.
        violated: share of the episodes in which a hard limit was crossed.
        governor: share of the time in which the governor acted.
        fibrosed: diagnosis of raised F_o.
        blocked: diagnosis of raised b.
    """

    entry: str
    trained: bool
    control: str
    note: str
    description: str
    information_true: Interval
    information_claimed: Interval
    information_bound: Interval
    honesty_gap: Interval
    difference: Interval | None
    worst_sd_median: Interval
    worst_sd_p90: Interval
    worst_sd_max: float
    identified: Interval
    rmse_over_bound: Interval
    nees: Interval
    nees_prior: float
    inside: dict[int, Interval]
    share_to: dict[float, Interval]
    time_to: dict[float, Interval]
    discomfort_s: Interval
    largest_fraction: float
    violated: Interval
    governor: Interval
    fibrosed: Diagnosis
    blocked: Diagnosis


@dataclass(frozen=True)
class Ranking:
    """The entries of a study in the order of their true information.

    Attributes:
        rows: best first.
        env: id of the environment that all were played in.
        parameters: names of what was to be identified.
        reference: the entry that differences are taken against.
        patients: how many.
        band: in which 95 % of honest studies of this size have their mean NEES.
    """

    rows: tuple[Row, ...]
    env: str
    parameters: tuple[str, ...]
    reference: str
    patients: int
    band: tuple[float, float]

    @property
    def n_parameters(self) -> int:
        """How many parameters there are, which is also what an honest NEES is on average."""
        return len(self.parameters)

    def calibration(self, row: Row) -> str:
        """`honest`, `overconfident` or `cautious`, by the mean NEES against its band."""
        if row.nees.value > self.band[1]:
            return "overconfident"
        return "cautious" if row.nees.value < self.band[0] else "honest"


def rank(study: Results, reference: str | None = None) -> Ranking:
    """Order the entries of a study and give every figure its interval.

    Args:
        study: results of all entries on the same patients.
        reference: label of the entry that the others are compared with; the best by default.

    Raises:
        InputError: no entry has the label `reference`.
    """
    order = sorted(study.entries, key=lambda entry: -study.of(entry)["information_true"].mean())
    if reference is not None and reference not in order:
        raise InputError(f"reference: {reference!r} given, allowed are {', '.join(order)}")
    against = reference or order[0]
    number = len(study.of(against))
    return Ranking(
        rows=tuple(_row(study, entry, against) for entry in order),
        env=study.env,
        parameters=study.parameters,
        reference=against,
        patients=number,
        band=nees_band(number, len(study.parameters)),
    )


def _row(study: Results, entry: str, reference: str) -> Row:
    table = study.of(entry)

    def mean(column: str) -> Interval:
        return statistics.mean(table[column].to_numpy(dtype=np.float64))

    about: dict[str, Any] = next((each for each in study.about["entries"] if each["label"] == entry), {})
    targets = [match.group(1) for match in map(_TIME_TO.fullmatch, map(str, table)) if match]
    times = {float(target): table[f"time_to_{target}_s"].to_numpy(dtype=np.float64) for target in targets}
    truth, error, sd = (study.array(entry, name) for name in ("truth", "error", "sd"))
    forces = np.array([name.startswith("log_F_o/") for name in study.parameters])
    fibrosed_F_o_N = FIBROSED_F_O_N * whole_muscles_per_line(study.parameters)
    diagnoses = {
        name: diagnose(truth[:, columns], (truth + error)[:, columns], sd[:, columns], threshold)
        for name, columns, threshold in (("fibrosed", forces, fibrosed_F_o_N), ("blocked", ~forces, BLOCKED_B))
    }
    information = table["information_true"].to_numpy()
    paired = study.of(reference)["information_true"].to_numpy()
    return Row(
        entry=entry,
        trained=about.get("trained", False),
        control=about.get("env_kwargs", {}).get("control", "?"),
        note=about.get("note", ""),
        description=about.get("description", ""),
        information_true=mean("information_true"),
        information_claimed=mean("information_claimed"),
        information_bound=mean("information_bound"),
        honesty_gap=mean("honesty_gap"),
        difference=None if entry == reference else statistics.difference(information, paired),
        worst_sd_median=statistics.quantile(table["worst_sd"].to_numpy(), 0.5),
        worst_sd_p90=statistics.quantile(table["worst_sd"].to_numpy(), 0.9),
        worst_sd_max=float(table["worst_sd"].max()),
        identified=mean("identified"),
        rmse_over_bound=statistics.rmse_over_bound(error, study.array(entry, "bound_sd")),
        nees=mean("nees"),
        nees_prior=float(table["nees_prior"].mean()),
        inside={sigmas: mean(f"inside_{sigmas}_sigma") for sigmas in SIGMAS},
        share_to={target: statistics.mean(np.isfinite(seconds)) for target, seconds in times.items()},
        time_to={target: statistics.quantile(seconds, 0.5) for target, seconds in times.items()},
        discomfort_s=mean("discomfort_s"),
        largest_fraction=float(table["largest_fraction"].max()),
        violated=mean("violated"),
        governor=mean("governor"),
        **diagnoses,
    )
