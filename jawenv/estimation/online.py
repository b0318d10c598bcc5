"""The environments' own filter, run over a record."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.compiled import njit
from jawenv.errors import InputError
from jawenv.estimation.estimator import Estimate
from jawenv.estimation.record import Record
from jawenv.estimation.replay import ends_window, online_scratch_dtype, renew, replay
from jawenv.estimation.tension_basis import build_basis, nodes_needed
from jawenv.estimation.tension_belief import begin_belief, belief_dtype
from jawenv.estimation.tick import (
    EAGER_TICKS,
    begin_motion,
    filter_settings_dtype,
    learn,
    leaves_pose_open,
    take_readings,
    tick_dtype,
)

Array = NDArray[np.float64]


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
        run = FilterRun(record)
        times, size = record.time[:: self.every], len(record.prior.mean)
        mean, cov = np.empty((len(times), size)), np.empty((len(times), size, size))
        filter_record(*run.arguments, self.every, mean, cov)
        return Estimate(self.name, times, mean, cov)


class FilterRun:
    """What the kernels need to filter a record: the jaw, the device, and memory as before the first reading.

    Args:
        record: it.
    """

    def __init__(self, record: Record) -> None:
        """Make the arrays; the belief is the prior."""
        states, muscles = len(record.start_mean), len(record.parameter_names) // 2
        nodes, lines = nodes_needed(record.prior), len(record.jaw["l_o"])
        settings = np.zeros(1, dtype=filter_settings_dtype(muscles, states, nodes))[0]
        device, settings["trajectory"] = record.answering()
        settings["dt"], settings["gain_variance"] = record.dt, record.gain_sd**2
        settings["measurement_variance"], settings["noise_variance"] = record.measurement_sd**2, record.noise_variance
        settings["used"], settings["start_sd"] = True, record.start_sd
        there = np.isfinite(record.measured)
        used, read_share = np.asarray(there.any(axis=0)), float(there.any(axis=1).mean())
        settings["pose_open"] = leaves_pose_open(used, record.start_sd, read_share)
        settings["basis"] = build_basis(record.jaw, record.prior, nodes)[0]
        settings["prior_mean"], settings["prior_sd"] = record.prior.mean, record.prior.sd
        self.belief = np.zeros(1, dtype=belief_dtype(muscles, lines, states, nodes))[0]
        scratch = np.zeros(1, dtype=online_scratch_dtype(muscles, lines, states, nodes))[0]
        rows = _rows(record)
        self.settings = settings
        self.arguments = record.jaw, device, self.belief, rows, settings, scratch
        self.last = len(rows) - 1


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
    run = FilterRun(record)
    jaw, device, belief, rows, settings, scratch = run.arguments
    replay_about(jaw, device, belief, rows, run.last, settings, scratch, np.ascontiguousarray(parameters))
    return belief["mode_mean"].copy(), belief["mode_cov"].copy()


def _rows(record: Record) -> Any:
    """The record's readings as ``replay`` takes them."""
    rows = np.zeros(len(record.time), dtype=tick_dtype(len(record.start_mean)))
    rows["measured"], rows["samples"][1:] = record.measured, record.samples
    rows["believed"][0] = record.start_mean
    return rows


@njit
def replay_about(jaw, device, belief, rows, tick, settings, scratch, parameters):
    """``replay`` about parameters (p) that nothing is known of but the prior."""
    begin_belief(settings.basis, belief, parameters, settings.prior_sd)
    replay(jaw, device, belief, rows, tick, settings, scratch)


@njit
def filter_record(jaw, device, belief, rows, settings, scratch, every, means, covs):
    """Run the filter over ``rows`` (T + 1); after every ``every`` ticks the belief goes to ``means`` and ``covs``."""
    begin_motion(belief, rows[0].believed, settings.start_sd)
    begin_belief(settings.basis, belief, settings.prior_mean, settings.prior_sd)
    for tick in range(rows.shape[0]):
        take_readings(jaw, device, belief, rows[tick].measured, rows[tick].samples, tick, settings, scratch)
        if ends_window(belief, settings, scratch):
            renew(jaw, device, belief, rows, tick, settings, scratch)
        if tick < EAGER_TICKS:
            learn(belief, settings, scratch)
        if tick > 0 and tick % every == 0:
            learn(belief, settings, scratch)
        if tick % every == 0:
            means[tick // every] = belief.mean
            covs[tick // every] = belief.cov
