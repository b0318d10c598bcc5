"""State of the online filter, and its initialisation.

Three parts make the bias-separated form of the Kalman filter (Friedland 1969, IEEE Trans. Autom. Control 14:359):

* ``motion`` (q, u) and its covariance ``motion_cov``, given muscles at ``mean``;
* ``by_tension``, the derivative of that motion by the coefficients c of ``basis`` and by the load cell's gain error;
* ``information`` and ``score``, matrix and gradient at ``nominal`` of the quadratic log-likelihood of c and the gain
  error, accumulated from the innovations. Between two updates of the belief the matrix's upper half alone is kept.

Forces are linear in c, so the information of early data, linearised at a poor estimate, is as valid as that of late
data, and the constant parameters need no process noise. The belief about the natural-log parameters, ``mean`` and
``cov``, follows from information, score and prior (``posterior``).
"""

from __future__ import annotations

from functools import cache

import numpy as np

from jawenv.device.device import N_MOTORS
from jawenv.filter.alarm.drift import begin_drift, drift_dtype
from jawenv.filter.belief.basis import N_NODES, basis_dtype, set_coefficients
from jawenv.filter.motion.motion_step import padded
from jawenv.filter.readings.encoders import N_MEASUREMENTS
from jawenv.kernels.compiled import njit
from jawenv.kernels.records import record_dtype
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.jaw import jaw_dtype


def tension_columns(n_muscles: int, n_nuisances: int = 0) -> int:
    """Columns of ``by_tension``: the coefficients, the gain error, other nuisances, and zeros at the end."""
    return padded(n_muscles * N_NODES + 1 + n_nuisances)


@cache
def block_dtype(columns: int) -> np.dtype[np.void]:
    """Dtype of the sums of a block of ticks, see ``misfit``."""
    fields = [
        ("ticks", "i8"),
        ("innovation", "f8", (N_MEASUREMENTS,)),  # whitened
        ("rows", "f8", (N_MEASUREMENTS, columns)),  # whitened rows by tension
        ("largest", "f8"),  # misfit of the blocks so far
        ("second", "f8"),
    ]
    return record_dtype(fields)


@cache
def belief_dtype(
    n_muscles: int, n_states: int, n_lines: int = 1, n_nuisances: int = 0, n_disturbance: int = 0
) -> np.dtype[np.void]:
    """Dtype of the filter's state."""
    size, parameters, n_motion = tension_columns(n_muscles, n_nuisances), 2 * n_muscles, n_states + n_disturbance
    fields = [
        ("motion", "f8", (n_motion,)),  # and after it the disturbance, where it has memory
        ("motion_cov", "f8", (n_motion, n_motion)),
        ("by_tension", "f8", (n_motion, size)),
        ("information", "f8", (size, size)),
        ("score", "f8", (size,)),
        ("basis", basis_dtype(n_muscles)),
        ("block", block_dtype(size)),
        ("drift", drift_dtype(parameters)),
        ("misfit", "f8"),  # the alarm, see ``misfit``
        ("nominal", "f8", (n_muscles, N_NODES)),  # c at ``mean``
        ("nuisances", "f8", (n_nuisances,)),  # their mean, in prior sds
        ("nuisances_replayed_at", "f8", (n_nuisances,)),
        ("friction_share", "f8", (N_MOTORS if n_nuisances else 0,)),  # see ``device.force_sensor``
        ("jaw", jaw_dtype(n_lines if n_nuisances else 1)),  # the filter's model at that mean, where there are nuisances
        (
            "predicted",
            "f8",
            (n_states if n_nuisances + n_disturbance else 0,),
        ),  # motion at the tick's end as the past alone has it
        ("smoothed", "f8", (N_WRENCH,)),  # the load cell's trend over a shorter time, corrected
        # L^-1 of ``decompose``, of the information about gain error and nuisances at given tensions
        ("nuisance_factor", "f8", (n_nuisances + 1, n_nuisances + 1)),
        ("mean", "f8", (parameters,)),  # natural logs
        ("cov", "f8", (parameters, parameters)),
        ("replayed_at", "f8", (parameters,)),  # mean at which the readings were last filtered from the first on
        ("trend", "f8", (N_WRENCH,)),  # of the load cell
        ("readings", "i8"),  # ticks at the end of which an encoder was used
        ("waits", "i8"),  # ticks of which nothing is learnt from here on, see ``readings.screening``
        ("gated", "i8"),  # ticks whose innovation the gate rejected when they were read
        ("last_measured", "f8", (N_MEASUREMENTS,)),
        ("encoder_step", "f8", (N_MEASUREMENTS,)),  # see ``readings.screening``; infinite before a change
        ("repeats", "f8", (N_MEASUREMENTS,)),  # how often in a row each encoder has shown the same; infinite if frozen
        ("cell_step", "f8", (N_WRENCH,)),
        ("unchanged_at", "f8", (6,)),  # pose (q) when the load cell last changed
        ("held_sample", "f8", (N_WRENCH,)),
        ("lost_for", "f8", (N_WRENCH,)),  # s since the load cell's component was used
    ]
    return record_dtype(fields)


@njit
def begin_motion(belief, motion, sd):
    """Set the mean of the motion (n) before the first reading, no disturbance, and the sds of both."""
    belief.motion[:] = 0.0
    for i in range(motion.shape[0]):
        belief.motion[i] = motion[i]
    for i in range(belief.predicted.shape[0]):
        belief.predicted[i] = motion[i]
    lose_motion(belief, sd)


@njit
def lose_motion(belief, sd):
    """Reset the motion's covariance to ``sd`` (n), uncorrelated with the tensions; the mean stays."""
    belief.motion_cov[:, :] = 0.0
    for i in range(sd.shape[0]):
        belief.motion_cov[i, i] = sd[i] * sd[i]
    belief.by_tension[:, :] = 0.0


@njit
def begin_belief(basis, belief, log_parameters, prior_sd):
    """Initialise the parameters: mean ``log_parameters`` (p), the prior's sds.

    ``log_parameters`` are the prior's mean, or another linearisation point. The caller sets the motion.
    """
    belief.cov[:, :] = 0.0
    for i in range(log_parameters.shape[0]):
        belief.mean[i] = log_parameters[i]
        belief.replayed_at[i] = log_parameters[i]
        belief.cov[i, i] = prior_sd[i] * prior_sd[i]
    copy_basis(belief.basis, basis)
    begin_drift(belief.drift)
    belief.misfit = 0.0
    belief.nuisances[:] = 0.0
    belief.nuisances_replayed_at[:] = 0.0
    belief.nuisance_factor[:, :] = 0.0
    for i in range(belief.nuisance_factor.shape[0]):
        belief.nuisance_factor[i, i] = 1.0
    forget_readings(belief)


@njit
def copy_basis(target, source):
    """Target = source."""
    target.middle[:] = source.middle
    target.width[:] = source.width
    target.abscissae[:] = source.abscissae
    target.nodes[:, :] = source.nodes
    target.centre[:] = source.centre
    target.polynomials[:, :, :] = source.polynomials


@njit
def begin_block(block):
    """Sums of no tick."""
    block.ticks = 0
    block.innovation[:] = 0.0
    block.rows[:, :] = 0.0


@njit
def forget_readings(belief):
    """Discard all information and sensor history; motion and belief stay."""
    belief.by_tension[:, :] = 0.0
    belief.information[:, :] = 0.0
    belief.score[:] = 0.0
    belief.trend[:] = 0.0
    belief.smoothed[:] = 0.0
    belief.friction_share[:] = 0.0
    begin_block(belief.block)
    belief.block.largest, belief.block.second, belief.waits = 0.0, 0.0, 0
    belief.readings = 0
    belief.last_measured[:] = np.nan
    belief.encoder_step[:] = np.inf
    belief.repeats[:] = 0.0
    belief.cell_step[:] = np.inf
    belief.unchanged_at[:] = 0.0
    belief.held_sample[:] = 0.0
    belief.lost_for[:] = 0.0
    set_coefficients(belief.basis, belief.mean, belief.nominal)
