"""The likelihood of the muscles and of the patient's own anatomy together, after an episode.

The filter integrates everything out but the muscles. Whoever compares two episodes of a patient must not: the anatomy
is the same in both, and so are the errors that come of it. Here the session's part alone is integrated out (load cell,
mouthpiece, tilt of the head), and no prior is counted but the session's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.envs.simulation import Simulation
from jawenv.filter.belief.posterior import set_omega
from jawenv.filter.belief.state import shared_columns
from jawenv.filter.model.basis import N_NODES, expand_coefficients
from jawenv.filter.nuisances.unknowns import own_values

Array = NDArray[np.float64]


@dataclass(frozen=True)
class JointLikelihood:
    """The quadratic log likelihood of x, ``vector @ x - x @ information @ x / 2`` but for a constant.

    x are P natural-log parameters, and behind them Q values of the patient's own anatomy in prior sds, as
    ``filter.nuisances.unknowns.own_values`` has them. It does not depend on where the filter was linearised last.
    """

    information: Array  # (P + Q, P + Q)
    vector: Array  # (P + Q,)

    def posterior(self, mean: Array, cov: Array) -> tuple[Array, Array]:
        """Mean (P + Q) and covariance of x after a normal prior with these.

        Args:
            mean: (P + Q,).
            cov: (P + Q, P + Q) positive definite.
        """
        after = np.linalg.inv(np.linalg.inv(cov) + self.information)
        after = 0.5 * (after + after.T)
        return mean + after @ (self.vector - self.information @ mean), after


def joint_likelihood(simulation: Simulation, index: int) -> JointLikelihood:
    """The joint likelihood of world ``index``, from its filter so far."""
    if simulation.knowledge.exact:
        raise InputError("knowledge is exact; allowed: knowledge within sds, as imaged")
    return _likelihood(simulation, index, np.array([own_values(values) for values in simulation.nuisance_sds]))


def belief_of_nuisances(simulation: Simulation, index: int) -> tuple[Array, Array]:
    """Mean and sd (q,) of every nuisance of world ``index`` in prior sds, in the filter's order; 0 and 1 before."""
    size, prior = len(simulation.nuisance_sds), simulation.cohort.prior
    likelihood = _likelihood(simulation, index, np.eye(size))
    start = np.concatenate([prior.mean, np.zeros(size)]), np.diag(np.concatenate([prior.sd, np.ones(size)]) ** 2)
    mean, cov = likelihood.posterior(*start)
    return mean[-size:], np.sqrt(np.diagonal(cov)[-size:])


def _likelihood(simulation: Simulation, index: int, own: Array) -> JointLikelihood:
    """The likelihood of muscles and Q values in world ``index``; ``own`` (nuisances, Q) holds an sd of each value."""
    belief = simulation.worlds["known"]["belief"][index]
    gain_variance = float(simulation.settings[0]["filter"]["gain_variance"])
    derivative, at_zero, count = _linearised(belief, own, gain_variance)
    columns = len(derivative)
    upper = np.triu(belief["information"][:columns, :columns])
    information = upper + np.triu(upper, 1).T
    joint = derivative.T @ information @ derivative
    vector = derivative.T @ (belief["score"][:columns] - information @ at_zero)
    # What is not kept has the prior N(0, 1), and is integrated out.
    rest = joint[count:, count:] + np.eye(len(joint) - count)
    carried = np.linalg.solve(rest, joint[count:, :count])
    left = joint[:count, :count] - joint[:count, count:] @ carried
    return JointLikelihood(0.5 * (left + left.T), vector[:count] - carried.T @ vector[count:])


def _linearised(belief: Any, own: Array, gain_variance: float) -> tuple[Array, Array, int]:
    """The filter's columns (coefficients, gain error, nuisances), less their present mean, by standard numbers.

    Args:
        belief: record of ``filter.belief.state.belief_dtype``.
        own: (nuisances, Q) what one sd of each is in the patient's own values; zeros where it is the session's.
        gain_variance: of the load cell.

    Returns:
        Derivative (columns, P + Q + rest), value at zero (columns,), and P + Q. The rest are the linearisation errors
        of the coefficients (``filter.belief.posterior``), the gain error and the session's nuisances.
    """
    mean, cov = belief["mean"], belief["cov"]
    muscles = len(mean) // 2
    size, bends = muscles * N_NODES, 3 * muscles
    coefficients, by_log_twice = np.empty((muscles, N_NODES)), np.empty((muscles, N_NODES, 3))
    expand_coefficients(belief["basis"], mean, cov, coefficients, by_log_twice)
    bent = np.zeros((size, bends))
    for i in range(muscles):
        bent[i * N_NODES : (i + 1) * N_NODES, 3 * i : 3 * i + 3] = by_log_twice[i]
    omega = np.empty((bends, bends))
    set_omega(cov, omega)
    sizes, axes = np.linalg.eigh(omega)
    session = np.flatnonzero(~own.any(axis=1))
    parameters, count = len(mean), len(mean) + own.shape[1]
    gains = shared_columns(len(own)) - len(own)
    derivative = np.zeros((size + gains + len(own), count + bends + gains + len(session)))
    derivative[:size, :parameters] = np.delete(bent, np.s_[2::3], axis=1)
    derivative[:size, count : count + bends] = bent @ axes * np.sqrt(np.maximum(sizes, 0.0))
    for k in range(gains):
        derivative[size + k, count + bends + k] = np.sqrt(gain_variance)
    derivative[size + gains :, parameters:count] = own
    derivative[size + gains + session, count + bends + gains + np.arange(len(session))] = 1.0
    at_zero = np.zeros(len(derivative))
    at_zero[:size] = (coefficients - belief["nominal"]).ravel() - derivative[:size, :parameters] @ mean
    at_zero[size + gains :] = -belief["nuisances"]
    return derivative, at_zero, count
