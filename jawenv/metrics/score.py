"""Every metric of a recording, patient by patient."""

from __future__ import annotations

import math
from dataclasses import dataclass
from html import escape

import numpy as np
import numpy.typing as npt

from jawenv.metrics.calibration import alarm_rings, claimed_information, covered, nees, true_information
from jawenv.metrics.diagnosis import BLOCKED_B, CONFIDENCE, STIFF_F_O_N, Diagnosis, diagnose, whole_muscles_per_line
from jawenv.metrics.precision import identified, rmse, rmse_over_bound, time_to, worst_sd
from jawenv.playing.recording import Recording

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

TARGETS = (0.10, 0.05, 0.02)
IDENTIFIED_SD, KNOWN = 0.10, 0.05
"""Largest sd of an identified parameter, and of one that is known."""
_ROWS = {
    "patients": ("patients", "{:.0f}"),
    "worst_sd_median": ("worst sd, median", "{:.1%}"),
    "worst_sd_p90": ("worst sd, nine of ten patients below", "{:.1%}"),
    "time_to_0.1_median_s": ("all within 10 % after, s, median", "{:.1f}"),
    "time_to_0.05_median_s": ("all within 5 % after, s, median", "{:.1f}"),
    "rmse": ("root mean square error", "{:.1%}"),
    "identified": ("parameters identified", "{:.1f}"),
    "information_true": ("true information, nats", "{:.1f}"),
    "information_claimed": ("claimed information, nats", "{:.1f}"),
    "nees": ("NEES", "{:.1f}"),
    "inside_2_sigma": ("truth within two sds", "{:.0%}"),
    "discomfort_s": ("discomfort, s", "{:.3f}"),
    "violation_share": ("episodes that cross a hard limit", "{:.0%}"),
    "ringing_share": ("episodes in which the alarm rings", "{:.0%}"),
}
"""Key -> what a table calls it, and how it is written. Keys that are not here are in the mapping alone."""


class Summary(dict[str, float]):
    """Figures over the patients by name; printed, or shown in a notebook, a table of the main ones."""

    def __str__(self) -> str:
        rows = self._rows()
        width = max(len(words) for words, _ in rows)
        return "\n".join(f"{words:{width}s}  {value:>8s}" for words, value in rows)

    def _repr_html_(self) -> str:
        cells = (
            f"<tr><td style='text-align: left'>{escape(words)}</td><td>{value}</td></tr>"
            for words, value in self._rows()
        )
        return f"<table>{''.join(cells)}</table>"

    def _rows(self) -> list[tuple[str, str]]:
        return [(words, _written(self[key], form)) for key, (words, form) in _ROWS.items() if key in self]


def _written(value: float, form: str) -> str:
    if math.isnan(value):
        return "–"
    return form.format(value) if math.isfinite(value) else "never"


@dataclass(frozen=True)
class Score:
    """The metrics of N episodes at their ends; P parameters, natural logs, so an sd of 0.05 is 5 %."""

    parameter_names: tuple[str, ...]  # P names
    sd: Array  # (N, P) claimed standard deviations
    error: Array  # (N, P) estimate minus truth
    bound_sd: Array  # (N, P) posterior Cramer-Rao bound, NaN where not tracked
    worst_sd: Array  # (N,) largest of the P claimed standard deviations, or of those of the muscles that are asked for
    worst_bound_sd: Array  # (N,) largest of these bounds
    time_to_s: dict[float, Array]  # threshold of the worst sd -> (N,) s until it was reached, infinite if never
    information_claimed: Array  # (N,) nats by the claimed covariance
    information_true: Array  # (N,) nats by the log score
    information_bound: Array  # (N,) nats by the bound, NaN where not tracked
    nees: Array  # (N,) of the posterior; P on average if it is honest
    nees_prior: Array  # (N,) of the prior at the same truth; below P where the cohort is narrower than the prior
    inside: dict[int, Array]
    """Sigmas -> (N,) share of the parameters whose truth lies within so many claimed standard deviations."""
    rmse: Array  # (N,) root mean squared error over the parameters
    identified: npt.NDArray[np.intp]  # (N,) number of parameters with sd <= 10 % and the truth inside the 95 % interval
    discomfort_s: Array  # (N,) integral of the cost over time
    largest_fraction: Array  # (N,) largest used fraction of a soft comfort limit
    violated: Mask  # (N,) bool, a hard limit was crossed
    misfit: Array  # (N,) the filter's alarm, the largest of the episode: above 1 the readings do not fit the model
    governor: Array  # (N,) share of the time in which the governor acted
    duration_s: Array  # (N,) length of the episode
    stiff: Diagnosis  # decisions on raised F_o
    blocked: Diagnosis  # decisions on raised b

    def _repr_html_(self) -> str:
        return self.summary()._repr_html_()

    @property
    def honesty_gap(self) -> Array:
        """(N,) claimed minus true information, nats: above 0 the filter claims more than it delivers."""
        return self.information_claimed - self.information_true

    @property
    def rings(self) -> Mask:
        """(N,) bool, the alarm rings: the readings do not fit the model, and the belief is not to be trusted."""
        return alarm_rings(self.misfit)

    @property
    def alarm(self) -> str:
        """A warning if the alarm rings in any episode, otherwise empty."""
        share = f"{100.0 * np.mean(self.rings):.0f} %"
        return f"the readings of {share} of the patients do not fit the model" if self.rings.any() else ""

    @property
    def rmse_over_bound(self) -> Array:
        """(P,) root mean squared error over the patients, over the bound."""
        return rmse_over_bound(self.error, self.bound_sd)

    def summary(self) -> Summary:
        """Aggregate over the patients: means, and median, 90 % quantile and maximum of the worst sd.

        A mapping of names to figures; printed, or shown in a notebook, it is a table of the main ones.

        The median time to a target counts the patients who never reach it as infinitely late, so that it is
        infinite when fewer than half of them do; `share_to_*` says how many do.
        """
        table = Summary(
            {
                "patients": float(len(self.nees)),
                "worst_sd_median": float(np.median(self.worst_sd)),
                "worst_sd_p90": float(np.quantile(self.worst_sd, 0.9)),
                "worst_sd_max": float(np.max(self.worst_sd)),
                "rmse": float(rmse(self.error, axis=(0, 1))),
                "rmse_over_bound_mean": float(np.mean(self.rmse_over_bound)),
                "rmse_over_bound_max": float(np.max(self.rmse_over_bound)),
                "honesty_gap": float(np.mean(self.honesty_gap)),
                "violation_share": float(np.mean(self.violated)),
                "ringing_share": float(np.mean(self.rings)),
                "misfit_max": float(np.max(self.misfit)),
                "largest_fraction_max": float(np.max(self.largest_fraction)),
            }
        )
        means = ("information_claimed", "information_true", "information_bound", "nees", "nees_prior")
        for name in (*means, "identified", "discomfort_s", "governor"):
            table[name] = float(np.mean(getattr(self, name)))
        for sigmas, share in self.inside.items():
            table[f"inside_{sigmas}_sigma"] = float(np.mean(share))
        for target, seconds in self.time_to_s.items():
            table[f"share_to_{target:g}"] = float(np.mean(np.isfinite(seconds)))
            table[f"time_to_{target:g}_median_s"] = float(np.quantile(seconds, 0.5, method="inverted_cdf"))
        for name, decisions in (("stiff", self.stiff), ("blocked", self.blocked)):
            table[f"{name}_sensitivity"] = decisions.sensitivity
            table[f"{name}_specificity"] = decisions.specificity
        return table


def score(
    recording: Recording,
    *,
    targets: tuple[float, ...] = TARGETS,
    untold: bool = False,
) -> Score:
    """Judge a recording: precision, honesty, comfort and diagnosis of every patient when the episode ends.

    Args:
        recording: see `jawenv.playing.rollout.play`.
        targets: thresholds of the worst sd whose time is taken.
        untold: whether the last belief learns the sizes of errors that nobody told the filter of, from `records`; what
            is said of times before stays the filter's.

    Returns:
        The metrics per patient; `.summary()` aggregates them.

    Raises:
        InputError: a covariance is not positive definite, or ``untold`` without records.
    """
    mean, cov = recording.at_end(recording.belief_mean), recording.at_end(recording.belief_cov)
    if untold:
        from jawenv.recordings.untold.learnt import learnt_beliefs

        mean, cov = learnt_beliefs(recording.records, mean, cov)
    truth, error = recording.truth, mean - recording.truth
    sd, bound_sd = np.sqrt(np.diagonal(cov, axis1=-2, axis2=-1)), recording.at_end(recording.bound_sd)
    over_time = recording.of_asked(recording.belief_sd)
    lived = np.diff(recording.time) * recording.valid[:, 1:]
    forces = np.array([name.startswith("log_F_o/") for name in recording.parameter_names])
    stiff_F_o_N = STIFF_F_O_N * whole_muscles_per_line(recording.parameter_names)
    prior_cov = np.diag(np.square(recording.prior_sd))
    return Score(
        parameter_names=recording.parameter_names,
        sd=sd,
        error=error,
        bound_sd=bound_sd,
        worst_sd=worst_sd(recording.of_asked(sd)),
        worst_bound_sd=worst_sd(recording.of_asked(bound_sd)),
        time_to_s={target: time_to(over_time, recording.time, target, recording.counts) for target in targets},
        information_claimed=claimed_information(cov, recording.prior_sd),
        information_true=true_information(truth, mean, cov, recording.prior_mean, recording.prior_sd),
        information_bound=recording.at_end(recording.information_bound),
        nees=nees(error, cov),
        nees_prior=nees(recording.prior_mean - truth, prior_cov),
        inside={sigmas: covered(error, sd, sigmas).mean(axis=-1) for sigmas in (1, 2, 3)},
        rmse=rmse(error),
        identified=identified(mean, sd, truth, IDENTIFIED_SD).sum(axis=-1),
        discomfort_s=np.sum(recording.cost[:, 1:] * lived, axis=1),
        largest_fraction=np.max(recording.comfort * recording.valid[..., None], axis=(1, 2)),
        violated=np.asarray((recording.violation & recording.valid).any(axis=1)),
        misfit=recording.at_end(recording.misfit),
        governor=np.sum(recording.governor[:, 1:] * lived, axis=1) / np.maximum(lived.sum(axis=1), lived.max()),
        duration_s=recording.time[recording.last],
        stiff=diagnose(truth[:, forces], mean[:, forces], sd[:, forces], stiff_F_o_N, CONFIDENCE),
        blocked=diagnose(truth[:, ~forces], mean[:, ~forces], sd[:, ~forces], BLOCKED_B, CONFIDENCE),
    )
