"""What the online filter carries from tick to tick, and how it begins.

Three things make the bias-separated form of the Kalman filter (Friedland 1969, IEEE Trans. Autom. Control 14:359):

* ``motion`` (q, u) and its covariance ``motion_cov``, as if the muscles were known to be what ``mean`` says;
* ``by_tension``, the derivative of that motion by the coefficients c of ``basis`` and by the load cell's gain error;
* ``information`` and ``score``, matrix and gradient at ``nominal`` of the quadratic log-likelihood of c and the gain
  error, which the innovations have added up to.

Forces are linear in c, so that the information of early data, gathered about a poor guess, holds as well as that of
late data, and no noise has to be put on the parameters, which are constants. The belief about the natural-log
parameters, ``mean`` and ``cov``, is made of information, score and prior (``posterior``).
"""

from __future__ import annotations

from functools import cache

import numpy as np

from jawenv.compiled import njit
from jawenv.estimation.model.encoders import N_MEASUREMENTS
from jawenv.estimation.online.basis import N_NODES, basis_dtype, set_coefficients
from jawenv.estimation.online.step import padded
from jawenv.mechanics.dynamics import N_WRENCH


def tension_columns(n_muscles: int) -> int:
    """Columns of ``by_tension``: the coefficients, the gain error, and zeros at the end."""
    return padded(n_muscles * N_NODES + 1)


@cache
def belief_dtype(n_muscles: int, n_states: int) -> np.dtype[np.void]:
    """Dtype of what the filter carries from tick to tick."""
    size, parameters = tension_columns(n_muscles), 2 * n_muscles
    fields = [
        ("motion", "f8", (n_states,)),
        ("motion_cov", "f8", (n_states, n_states)),
        ("by_tension", "f8", (n_states, size)),
        ("information", "f8", (size, size)),
        ("score", "f8", (size,)),
        ("basis", basis_dtype(n_muscles)),
        ("nominal", "f8", (n_muscles, N_NODES)),  # c at ``mean``
        ("mean", "f8", (parameters,)),  # natural logs
        ("cov", "f8", (parameters, parameters)),
        ("trend", "f8", (N_WRENCH,)),  # of the load cell
        ("readings", "i8"),  # ticks at the end of which an encoder was used
        ("gated", "i8"),  # ticks whose innovation the gate has refused
        ("last_measured", "f8", (N_MEASUREMENTS,)),
        ("last_sample", "f8", (N_WRENCH,)),
        ("held_sample", "f8", (N_WRENCH,)),
        ("lost_for", "f8", (N_WRENCH,)),  # s since the load cell's component was used
    ]
    return np.dtype(fields, align=True)


@njit
def begin_motion(belief, motion, sd):
    """The motion (n) believed before the first reading, and its sds (n)."""
    belief.motion[:] = motion
    lose_motion(belief, sd)


@njit
def lose_motion(belief, sd):
    """Nothing is known of the motion but that it is within ``sd`` (n) of what is believed, whatever the muscles."""
    belief.motion_cov[:, :] = 0.0
    for i in range(sd.shape[0]):
        belief.motion_cov[i, i] = sd[i] * sd[i]
    belief.by_tension[:, :] = 0.0


@njit
def begin_belief(basis, belief, log_parameters, prior_sd):
    """Before any measurement: the mean is ``log_parameters`` (p), as uncertain as the prior is.

    ``log_parameters`` are the prior's mean, or another guess to filter with. The caller sets the motion.
    """
    belief.cov[:, :] = 0.0
    for i in range(log_parameters.shape[0]):
        belief.mean[i] = log_parameters[i]
        belief.cov[i, i] = prior_sd[i] * prior_sd[i]
    copy_basis(belief.basis, basis)
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
def forget_readings(belief):
    """Nothing has been measured yet; motion and belief stay."""
    belief.by_tension[:, :] = 0.0
    belief.information[:, :] = 0.0
    belief.score[:] = 0.0
    belief.trend[:] = 0.0
    belief.readings = 0
    belief.last_measured[:] = np.nan
    belief.last_sample[:] = np.nan
    belief.held_sample[:] = 0.0
    belief.lost_for[:] = 0.0
    set_coefficients(belief.basis, belief.mean, belief.nominal)
