"""The environments' own filter, run over a record."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.compiled import njit
from jawenv.errors import InputError
from jawenv.estimation.ekf import follow_trend
from jawenv.estimation.estimator import Estimate
from jawenv.estimation.measurement import N_MEASUREMENTS
from jawenv.estimation.readings import mark_usable, repair_samples
from jawenv.estimation.record import Record
from jawenv.estimation.sensitivity import N_NOISE
from jawenv.estimation.tension_basis import build_basis, nodes_needed
from jawenv.estimation.tension_filter import (
    EAGER_TICKS,
    begin_belief,
    belief_fields,
    conclude,
    forget_settling,
    predict_motion,
    tension_scratch_dtype,
    update_motion,
)

Array = NDArray[np.float64]

SEARCHES = 5  # for the belief at the end of a record, from the prior's covariance

_SETTINGS = [
    ("dt", "f8"),
    ("gain_variance", "f8"),
    ("measurement_variance", "f8", N_MEASUREMENTS),
    ("noise_variance", "f8", N_NOISE),
    ("has_servo", "u1"),
]


class TensionFilter:
    """The filter of the environments: see ``tension_filter``.

    Args:
        every: Ticks from one belief to the next; 5 as in the environments at 20 Hz.

    Raises:
        InputError: ``every`` is less than 1.
    """

    name = "tension filter"

    def __init__(self, *, every: int = 5) -> None:
        """Check the argument."""
        if every < 1:
            raise InputError(f"every: {every} given, allowed is 1 or more")
        self.every = every

    def estimate(self, record: Record) -> Estimate:
        """The belief at the start and after every ``every`` ticks."""
        times, size = record.time[:: self.every], len(record.prior.mean)
        mean, cov = np.empty((len(times), size)), np.empty((len(times), size, size))
        belief, settings, scratch, device = _begin(record, record.prior.mean)
        filter_record(
            record.jaw,
            device,
            belief,
            record.measured,
            record.samples,
            settings,
            scratch,
            EAGER_TICKS,
            self.every,
            mean,
            cov,
        )
        return Estimate(self.name, times, mean, cov)


def belief_about(record: Record, parameters: Array) -> tuple[Array, Array]:
    """What a whole record says of the parameters if the motion is filtered as if they were ``parameters``.

    The filter runs over the record without learning, and makes its belief at the end: the likelihood with the motion
    integrated out, about a path that no early guess has bent.

    Args:
        record: the record.
        parameters: (p,) natural logs.

    Returns:
        (p,) mean and (p, p) covariance.
    """
    belief, settings, scratch, device = _begin(record, parameters)
    never, size = len(record.time), len(parameters)
    kept = np.empty((1, size)), np.empty((1, size, size))
    filter_record(record.jaw, device, belief, record.measured, record.samples, settings, scratch, 0, never, *kept)
    for _ in range(SEARCHES):
        conclude(belief, settings["prior_mean"], settings["prior_sd"], settings["gain_variance"], scratch)
    return belief["belief_mean"].copy(), belief["belief_cov"].copy()


def _begin(record: Record, parameters: Array) -> tuple[Any, Any, Any, Any]:
    """The filter's memory before the first reading, its settings and scratch, and the device.

    ``parameters`` (p,) are those that the motion is filtered with at first.
    """
    states, muscles = len(record.start_mean), len(record.parameter_names) // 2
    nodes, lines = nodes_needed(record.prior), len(record.jaw["l_o"])
    basis = build_basis(record.jaw, record.prior, nodes)[0]
    belief = np.zeros(1, dtype=np.dtype(belief_fields(muscles, states, nodes), align=True))[0]
    scratch = np.zeros(1, dtype=tension_scratch_dtype(muscles, lines, states, nodes))[0]
    of_prior = [("prior_mean", "f8", 2 * muscles), ("prior_sd", "f8", 2 * muscles)]
    settings = np.zeros(1, dtype=np.dtype([*_SETTINGS, *of_prior], align=True))[0]
    settings["dt"], settings["gain_variance"] = record.dt, record.gain_sd**2
    settings["measurement_variance"], settings["noise_variance"] = record.measurement_sd**2, record.noise_variance
    device, settings["has_servo"] = record.answering()
    settings["prior_mean"], settings["prior_sd"] = record.prior.mean, record.prior.sd
    belief["motion"] = record.start_mean
    belief["motion_cov"] = np.diag(record.start_sd**2)
    begin_belief(basis, belief, parameters, record.prior.sd)
    return belief, settings, scratch, device


@njit
def filter_record(jaw, device, belief, measured, samples, settings, scratch, eager, every, means, covs):
    """Run the filter over (T + 1, 12) readings and (T, 3, 6) load-cell samples.

    The belief is renewed after each of the first ``eager`` ticks and every ``every`` ticks, and then kept in ``means``
    and ``covs``.
    """
    prior_mean, prior_sd, gain_variance = settings.prior_mean, settings.prior_sd, settings.gain_variance
    last, last_sample, known = np.full(measured.shape[1], np.nan), np.full(6, np.nan), np.empty(N_NOISE)
    held, lost_for = np.zeros(6), np.zeros(6)
    used, allowed = np.empty(measured.shape[1], np.uint8), np.ones(measured.shape[1], np.uint8)
    usable = np.empty(samples.shape[1:])
    for tick in range(measured.shape[0]):
        if tick > 0:
            known[:] = settings.noise_variance
            repair_samples(samples[tick - 1], last_sample, held, lost_for, settings.dt, known, usable)
            predict_motion(
                jaw,
                belief,
                usable,
                settings.dt,
                known,
                device,
                settings.has_servo,
                scratch,
            )
            follow_trend(belief.trend, usable, settings.dt)
        mark_usable(measured[tick], last, allowed, used)
        update_motion(jaw, belief, measured[tick], settings.measurement_variance, used, scratch)
        forget_settling(jaw, belief, tick)
        if tick < eager:
            conclude(belief, prior_mean, prior_sd, gain_variance, scratch)
        if tick > 0 and tick % every == 0:
            conclude(belief, prior_mean, prior_sd, gain_variance, scratch)
        if tick % every == 0:
            means[tick // every] = belief.belief_mean
            covs[tick // every] = belief.belief_cov
