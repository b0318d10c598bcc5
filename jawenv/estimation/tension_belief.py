"""What the online filter carries from tick to tick, how it begins, and what it believes of the muscles.

The belief about the natural-log parameters is made from the information that ``tension_filter`` gathers, and the prior
(``posterior``); the motion is then moved to the new mean.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from jawenv.compiled import njit, njit_within
from jawenv.estimation.aftermath import aftermath_fields, forget_aftermath
from jawenv.estimation.measurement import N_MEASUREMENTS
from jawenv.estimation.mixture import forget_modes, mixture_fields, sum_up
from jawenv.estimation.posterior import believe
from jawenv.estimation.refocus import refocus
from jawenv.estimation.tension_basis import basis_dtype, copy_basis, set_coefficients
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.jaw import N_TEETH

# Ticks at the start of which nothing is learned on a jaw with two condyles: 0.1 mm of an encoder's noise are 10 N of a
# disc, and until the discs' pressures are known, what they push passes for tension.
SETTLING_TICKS = 10
ROUNDS = 6  # at most, of the search for the belief: fewer stop short where a patient is far from the prior's mean


def tension_count(n_muscles: int, n_nodes: int) -> int:
    """Number of what information is gathered about: the coefficients and the gain error."""
    return n_muscles * n_nodes + 1


@cache
def belief_dtype(n_muscles: int, n_lines: int, n_states: int, n_nodes: int) -> np.dtype[np.void]:
    """Dtype of what the filter carries from tick to tick."""
    size, parameters = tension_count(n_muscles, n_nodes), 2 * n_muscles
    fields = [
        ("motion", "f8", (n_states,)),
        ("motion_cov", "f8", (n_states, n_states)),
        ("by_tension", "f8", (n_states, size)),
        ("tremble", "f8", (n_states, n_states)),
        *aftermath_fields(n_states),
        ("information", "f8", (size, size)),
        ("score", "f8", (size,)),
        ("basis", basis_dtype(n_muscles, n_nodes)),
        ("nominal", "f8", (n_muscles, n_nodes)),
        *mixture_fields(parameters),
        ("window", "i8"),  # how many of them were filtered again at the end of the last window
        ("trend", "f8", (N_WRENCH,)),
        ("tooth_depths", "f8", (N_TEETH,)),  # m, their means of late
        ("strain_mean", "f8", (n_lines,)),
        ("strain_variance", "f8", (n_lines,)),  # about that mean
        ("read", "i8"),  # ticks at the end of which an encoder was believed
        ("misfit", "f8"),  # minus log-likelihood of the readings, but for a constant, given the beliefs of their time
        ("last_measured", "f8", (N_MEASUREMENTS,)),
        ("last_sample", "f8", (N_WRENCH,)),
        ("held_sample", "f8", (N_WRENCH,)),
        ("lost_for", "f8", (N_WRENCH,)),  # s since the load cell's component was believed
    ]
    return np.dtype(fields, align=True)


@njit
def begin_belief(basis, belief, log_parameters, prior_sd):
    """Before any measurement: ``log_parameters`` (p), as uncertain as the prior is.

    The mean of the prior, or another guess to filter with; ``motion`` and ``motion_cov`` the caller has set.
    """
    forget_modes(belief)
    belief.window = 0
    guess(basis, belief, log_parameters, prior_sd)
    sum_up(belief)


@njit
def guess(basis, belief, log_parameters, prior_sd):
    """The mode is at ``log_parameters`` (p), as uncertain as the prior is, and nothing has been measured yet."""
    for i in range(log_parameters.shape[0]):
        belief.mode_mean[i] = log_parameters[i]
        for j in range(log_parameters.shape[0]):
            belief.mode_cov[i, j] = 0.0
        belief.mode_cov[i, i] = prior_sd[i] * prior_sd[i]
    copy_basis(belief.basis, basis)
    forget_readings(belief)


@njit
def forget_readings(belief):
    """Nothing has been measured yet; motion and belief stay."""
    belief.by_tension[:, :] = 0.0
    for i in range(belief.motion_cov.shape[0]):
        for j in range(belief.motion_cov.shape[0]):
            belief.tremble[i, j] = belief.motion_cov[i, j]
    forget_aftermath(belief)
    belief.information[:, :] = 0.0
    belief.score[:] = 0.0
    belief.trend[:] = 0.0
    belief.tooth_depths[:] = np.nan
    belief.strain_mean[:] = np.nan
    belief.strain_variance[:] = 0.0
    belief.read = 0
    belief.misfit = 0.0
    belief.last_measured[:] = np.nan
    belief.last_sample[:] = np.nan
    belief.held_sample[:] = 0.0
    belief.lost_for[:] = 0.0
    set_coefficients(belief.basis, belief.mode_mean, belief.nominal)


@njit
def forget_settling(jaw, belief, tick):
    """Drop what the innovations said in the ticks in which a jaw settles on its discs, in the filter's knowledge."""
    if jaw.condyles == 2 and tick < SETTLING_TICKS:
        belief.score[:] = 0.0
        belief.information[:, :] = 0.0


@njit
def recentre(belief, scratch):
    """Move motion and score to the belief's mean."""
    basis = belief.basis
    size, columns = belief.motion.shape[0], belief.by_tension.shape[1]
    nodes = basis.nodes.shape[1]
    set_coefficients(basis, belief.mode_mean, scratch.after)
    row = scratch.row
    for j in range(columns - 1):
        row[j] = scratch.after[j // nodes, j % nodes] - belief.nominal[j // nodes, j % nodes]
    row[columns - 1] = 0.0
    for i in range(size):
        for j in range(columns):
            belief.motion[i] += belief.by_tension[i, j] * row[j]
    information = belief.information
    for i in range(columns):
        for j in range(columns):
            belief.score[i] -= (information[i, j] if j <= i else information[j, i]) * row[j]
    for j in range(columns - 1):
        belief.nominal[j // nodes, j % nodes] = scratch.after[j // nodes, j % nodes]


@njit_within
def conclude(belief, prior_mean, prior_sd, gain_variance, scratch):
    """The belief about the parameters from all information so far; motion and score move to its mean."""
    believe(
        belief.basis,
        belief.information,
        belief.score,
        belief.nominal,
        gain_variance,
        prior_mean,
        prior_sd,
        belief.mode_mean,
        belief.mode_cov,
        scratch.posterior,
        ROUNDS,
    )
    recentre(belief, scratch)
    refocus(belief, scratch)
