"""Every entry's figures with their intervals: those that are ranked, the best first, then all others and why.

Ranked is by the time until all parameters are within 5 %: median over the patients, then the 90 % quantile, then the
share that gets there; among equals, as where nobody gets there, by true information, which overconfidence cannot raise.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from agents.registry import shipped_names
from eval.comparison.admission import LARGEST_RINGING, PER_S, AdmissionLimits, does_not_fit, false_sd
from eval.comparison.results import Results
from eval.figures import statistics
from eval.figures.statistics import Interval
from jawenv.errors import InputError
from jawenv.metrics import (
    BLOCKED_B,
    FIBROSED_F_O_N,
    Diagnosis,
    alarm_rings,
    diagnose,
    nees_band,
    whole_muscles_per_line,
)

SIGMAS = {1: 0.6827, 2: 0.9545, 3: 0.9973}
"""Share of a Gaussian within so many standard deviations of its mean."""
KNOWN = 0.05
"""All parameters are known when the worst sd is at most this."""
N_LETTERS = 26
CLAIRVOYANT = "plans with the patient's true parameters: a yardstick, no contestant"
_TIME_TO = re.compile(r"time_to_(.+)_s")


@dataclass(frozen=True)
class RankingRow:
    """One entry; means over the patients unless said otherwise, sd of natural logs, information in nats."""

    entry: str  # its label
    trained: bool  # whether it comes from a training run
    own: bool  # whether it does not come with the project, and is no replay of another entry
    control: str  # its control mode
    note: str  # in which settings it differs from those asked for
    description: str  # its own, in a sentence
    excluded: str  # why it is not ranked; empty if it is
    false_sd: str  # why its sds cannot be believed; empty if they can
    does_not_fit: str  # why nothing counts as known, where the alarm rings too often; else empty
    information_true: Interval  # by the log score
    information_claimed: Interval  # by the covariance
    information_bound: Interval  # by the posterior Cramer-Rao bound
    honesty_gap: Interval  # claimed minus true
    difference: Interval | None
    """True information minus the reference's, patient by patient; None for the reference itself."""
    worst_sd_median: Interval  # median over the patients of the worst sd of all parameters
    worst_sd_p90: Interval  # its 90 % quantile
    worst_sd_max: float  # its maximum
    identified: Interval  # number of parameters known
    rmse_over_bound: Interval  # error as a multiple of the bound
    nees: Interval  # the number of parameters if calibrated
    nees_prior: float  # the same of the prior, before anything was measured
    inside: dict[int, Interval]  # sigmas -> share of the truths within so many claimed standard deviations
    share_to: dict[float, Interval]  # target of the worst sd -> share of the patients that reach it
    time_to: dict[float, Interval]  # target -> median time, s, those who never reach it counted as infinitely late
    time_to_p90: dict[float, Interval]  # target -> its 90 % quantile
    discomfort_s: Interval  # integral of the cost
    discomfort_rate: float  # the same, s per 30 s, of all episodes together
    above_limit: Interval  # share of the episodes with more discomfort than is admitted on average
    largest_fraction: float  # largest used fraction of a soft limit in any patient
    violated: Interval  # share of the episodes in which a hard limit was crossed
    rings: Interval  # share of the episodes in which the alarm rings
    governor: Interval  # share of the time in which the governor acted
    fibrosed: Diagnosis  # diagnosis of raised F_o
    blocked: Diagnosis  # diagnosis of raised b


@dataclass(frozen=True)
class Ranking:
    """The entries of a study: the ranked ones, best first, then the others."""

    rows: tuple[RankingRow, ...]  # ranked, then the others in the same order among themselves
    env: str  # id of the environment that all were played in
    parameters: tuple[str, ...]  # names of the parameters to identify
    reference: str  # the entry that differences are taken against
    patients: int  # how many
    admission: AdmissionLimits  # limits of comfort
    effects: dict[str, float]
    """Fields of ``jawenv.reality.Reality`` that acted on the truth and that the filter did not know."""
    estimator: str  # mechanics that the filter believes in, if not the environment's own; else empty
    band: tuple[float, float]
    """In which 95 % of calibrated studies of this size have the mean NEES of all their entries (Bonferroni)."""
    asked: str = ""  # the muscles that are asked for, as the environment's argument; empty for all

    @property
    def ranked(self) -> tuple[RankingRow, ...]:
        """The rows that are ranked, best first."""
        return tuple(row for row in self.rows if not row.excluded)

    @property
    def others(self) -> tuple[RankingRow, ...]:
        """The rows that are not ranked."""
        return tuple(row for row in self.rows if row.excluded)

    def place(self, row: RankingRow) -> int | None:
        """The place of a row, from 1 on; None for one that is not ranked."""
        return None if row.excluded else self.rows.index(row) + 1

    def mark(self, row: RankingRow) -> str:
        """Mark of a row in figures: its place, or a letter where it is not ranked."""
        if not row.excluded:
            return str(self.place(row))
        number = self.others.index(row)
        return chr(ord("a") + number) if number < N_LETTERS else f"a{number}"

    @property
    def believed(self) -> bool:
        """Whether the sds of any entry can be believed."""
        return any(not row.false_sd for row in self.rows)

    @property
    def n_parameters(self) -> int:
        """Number of parameters, which is also the mean of a calibrated NEES."""
        return len(self.parameters)

    @property
    def sought(self) -> str:
        """What has to be known: all parameters, or those that are asked for."""
        return "the parameters asked for" if self.asked else f"all {self.n_parameters} parameters"

    @property
    def best(self) -> RankingRow | None:
        """The first ranked row with stated errors to be believed, by NEES and alarm; None if there is none."""
        return next((row for row in self.ranked if self.believes(row)), None)

    def believes(self, row: RankingRow) -> bool:
        """Whether a row's stated errors can be believed: neither too small, nor false, nor those of ringing alarms."""
        rings = row.rings.value > LARGEST_RINGING
        return self.calibration(row) != "overconfident" and not rings and not row.false_sd

    def calibration(self, row: RankingRow) -> str:
        """`calibrated`, `overconfident` or `cautious`, by the mean NEES against its band."""
        if row.nees.value > self.band[1]:
            return "overconfident"
        return "cautious" if row.nees.value < self.band[0] else "calibrated"


def rank(study: Results, reference: str | None = None, admission: AdmissionLimits | None = None) -> Ranking:
    """Order the entries of a study and give every figure its interval.

    Args:
        study: results of all entries on the same patients.
        reference: label of the entry that the others are compared with; the best by default.
        admission: limits of comfort; the defaults of ``AdmissionLimits`` without one.
    """
    if reference is not None and reference not in study.entries:
        raise InputError(f"reference is {reference!r}; allowed: {', '.join(study.entries)}")
    allowed = admission or AdmissionLimits()
    rows = sorted((_row(study, entry, allowed) for entry in study.entries), key=_order)
    against = reference or rows[0].entry
    number, parameters = len(study.of(against)), len(study.parameters)
    settings = study.about.get("settings", {})
    return Ranking(
        rows=tuple(replace(row, difference=_difference(study, row.entry, against)) for row in rows),
        env=study.env,
        parameters=study.parameters,
        reference=against,
        patients=number,
        admission=allowed,
        effects=settings.get("reality") or {},
        estimator=settings.get("estimator") or "",
        asked=settings.get("asked") or "",
        band=nees_band(number, parameters, 1.0 - 0.05 / len(rows)),
    )


def _order(row: RankingRow) -> tuple[float | bool, ...]:
    """Sorting key of rows."""
    soon = (row.time_to[KNOWN].value, row.time_to_p90[KNOWN].value, -row.share_to[KNOWN].value)
    return (bool(row.excluded), bool(row.does_not_fit), bool(row.false_sd), *soon, -row.information_true.value)


def _difference(study: Results, entry: str, reference: str) -> Interval | None:
    """True information of an entry minus the reference's on the same patients; None for the reference itself."""
    if entry == reference:
        return None
    own, other = (study.of(label)["information_true"].to_numpy() for label in (entry, reference))
    return statistics.difference(own, other)


def _row(study: Results, entry: str, admission: AdmissionLimits) -> RankingRow:
    table = study.of(entry)

    def mean(column: str) -> Interval:
        return statistics.mean(table[column].to_numpy(dtype=np.float64))

    metadata: dict[str, Any] = next((other for other in study.about["entries"] if other["label"] == entry), {})
    targets = [match.group(1) for match in map(_TIME_TO.fullmatch, map(str, table)) if match]
    times = {float(target): table[f"time_to_{target}_s"].to_numpy(dtype=np.float64) for target in targets}
    truth, error, sd = (study.array(entry, name) for name in ("truth", "error", "sd"))
    forces = np.array([name.startswith("log_F_o/") for name in study.parameters])
    fibrosed_F_o_N = FIBROSED_F_O_N * whole_muscles_per_line(study.parameters)
    diagnoses = {
        name: diagnose(truth[:, columns], (truth + error)[:, columns], sd[:, columns], threshold)
        for name, columns, threshold in (("fibrosed", forces, fibrosed_F_o_N), ("blocked", ~forces, BLOCKED_B))
    }
    nees, true, claimed = (float(table[name].mean()) for name in ("nees", "information_true", "information_claimed"))
    false = false_sd(nees, true, claimed, len(study.parameters))
    rings = alarm_rings(table["misfit"].to_numpy(dtype=np.float64))
    unfit = does_not_fit(float(rings.mean()))
    rate = PER_S * float(table["discomfort_s"].sum() / table["duration_s"].sum())
    per_30_s = PER_S * (table["discomfort_s"] / table["duration_s"]).to_numpy(dtype=np.float64)
    reasons = [CLAIRVOYANT] if metadata.get("clairvoyant") else []
    reasons += [reason for reason in (unfit, false) if reason]
    reasons += admission.reasons(rate, float(table["violated"].mean()))
    return RankingRow(
        entry=entry,
        trained=metadata.get("trained", False),
        own=metadata.get("spec", entry) not in shipped_names() and not metadata.get("replay_of"),
        control=metadata.get("env_kwargs", {}).get("control", "?"),
        note=metadata.get("note", ""),
        description=metadata.get("description", ""),
        excluded="; ".join(reasons),
        false_sd=false,
        does_not_fit=unfit,
        information_true=mean("information_true"),
        information_claimed=mean("information_claimed"),
        information_bound=mean("information_bound"),
        honesty_gap=mean("honesty_gap"),
        difference=None,
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
        time_to_p90={target: statistics.quantile(seconds, 0.9) for target, seconds in times.items()},
        discomfort_s=mean("discomfort_s"),
        discomfort_rate=rate,
        above_limit=statistics.mean((per_30_s > admission.discomfort_s).astype(np.float64)),
        largest_fraction=float(table["largest_fraction"].max()),
        violated=mean("violated"),
        rings=statistics.mean(rings.astype(np.float64)),
        governor=mean("governor"),
        **diagnoses,
    )
