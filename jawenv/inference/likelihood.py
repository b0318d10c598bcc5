"""The log-likelihood of parameters in a record, and its expected information."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from jawenv.analysis.bound import bound_along
from jawenv.analysis.identifiability import data_information
from jawenv.inference.likelihood_kernel import innovations_log_density
from jawenv.inference.settings import Array, log_parameters
from jawenv.recordings.record import Record
from jawenv.references.extended_kalman_kernel import Problem
from jawenv.references.initial import working_memory


def log_likelihood(record: Record, theta: ArrayLike) -> Array:
    """Log-density of a record's encoder readings, given the load cell's readings and the parameters.

    The innovations form (Schweppe 1965, IEEE Trans. Inf. Theory 11:61): with nu_k the encoders' innovations in an
    extended Kalman filter of motion and load-cell gain at fixed parameters, and S_k their covariance, it is the sum of
    log N(nu_k; 0, S_k). Linearised about the filtered motion, whose errors are small; the parameters are not
    linearised. Values that were not read are left out.

    It is of the model that the filter believes in, so it knows nothing of ``reality`` and of pymunk's contacts; where
    the filter loses the motion, as it may with ``sensors="point"``, the value means nothing. Where a stiff jaw's ticks
    are divided, on the teeth for one, the number of parts depends on the parameters, and the likelihood jumps by some
    hundredths of a nat.

    Args:
        record: T ticks of p parameters; its truth, states and prior are not read.
        theta: (m, p) natural-log parameters, or (p,).

    Returns:
        (m,) or (), nats; -inf where the model's motion is no number.

    Raises:
        InputError: another shape, parameters that are not finite, or a record that is not exact.
    """
    record.require_exact("log_likelihood")
    one = np.ndim(theta) == 1
    rows = log_parameters(np.asarray(theta)[None] if one else theta, len(record.parameter_names))
    problem, scratch = _problem(record), working_memory(record)
    parameters, values = rows.shape[1], np.empty(len(rows))
    sd = np.concatenate([record.start_sd, np.zeros(parameters), [record.gain_sd]])
    for i, row in enumerate(rows):
        mean = np.concatenate([record.start_mean, row, [0.0]])
        values[i] = innovations_log_density(problem, mean, np.diag(sd**2), scratch)
    values[~np.isfinite(values)] = -np.inf
    return values.reshape(()) if one else values


def _problem(record: Record) -> Problem:
    """The record as the filter's kernels read it."""
    size = len(record.parameter_names)
    return Problem(
        jaw=record.jaw,
        measured=np.ascontiguousarray(record.measured),
        samples=np.ascontiguousarray(record.samples),
        dt=record.dt,
        variances=record.measurement_sd**2,
        noise_variance=record.noise_variance,
        parameter_noise=np.zeros((len(record.samples), size)),
        linear=False,
        floor=np.zeros(size),
    )


def fisher_information(record: Record, theta: ArrayLike | None = None) -> Array:
    """Information about the parameters that a record's motion is expected to give, the prior not counted.

    The inverse of the posterior Cramer-Rao bound (Tichavsky, Muravchik & Nehorai 1998, IEEE Trans. Signal Process.
    46:1386) less the prior's share. It is the mean of minus the Hessian of ``log_likelihood`` over draws of the noise,
    to first order in the motion's errors and without what the innovations' variance itself tells. Exact where the load
    cell's gain is known (``cell_gain`` 0); else the bound considers the gain error instead of estimating it, and the
    information is a little less.

    Args:
        record: with true ``states``, as ``jawenv.simulate`` with ``states=True`` makes it.
        theta: (p,) natural-log parameters at which the model is linearised; None for the record's truth.

    Returns:
        (p, p), symmetric.

    Raises:
        InputError: the record has no states, there are no parameters, or they are not p finite numbers.
    """
    parameters = None if theta is None else np.asarray(theta, dtype=np.float64)
    bound = bound_along(record, parameters, every=len(record.time) - 1)
    return data_information(bound.cov[-1], bound.prior_sd)
