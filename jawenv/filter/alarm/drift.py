"""Drift: whether the belief moves further than what it claimed to know allows.

If the model is right, the belief at a later time t differs from the one at time s by N(0, P_s - P_t), as all that is
read in between is new (the martingale of Bayesian updating). So (m_t - m_s)^T P_s^-1 (m_t - m_s) is at most chi-squared
of p, the number of parameters. Tissue that creeps, a disturbance that lasts and a filter that is lost take the belief
along, by many of the sds that it stated, while every reading by itself looks well explained.

The belief is kept after 100, 200, 400 ... readings, and each later one is judged by all that are kept. The largest
statistic so far, over ``threshold``, goes into the alarm, ``misfit``. Where readings are filtered again, what is kept
is renewed with them: a belief that was linearised far from the truth claims what is not so, and the filter has given it
up.
"""

from __future__ import annotations

from math import sqrt

from jawenv.filter.belief.state import KEPT, Belief, Drift
from jawenv.kernels.cholesky import solve_lower
from jawenv.kernels.compiled import njit
from jawenv.kernels.linalg import decompose

EVERY = 100  # readings between two judgements; the first belief is kept after as many
MARGIN = 10.0  # sds of chi-squared above its mean: linearisation and a prior that is not the patients' take their share


@njit
def threshold(parameters):
    """A limit that chi-squared of p exceeds with a chance below 1e-4, of 12 parameters 1e-8."""
    return parameters + MARGIN * sqrt(2.0 * parameters)


@njit
def _squared_distance(drift: Drift, k, mean, step):
    """(m - m_k)^T P_k^-1 (m - m_k); ``step`` (p) is working memory."""
    for i in range(mean.shape[0]):
        step[i] = mean[i] - drift.means[k, i]
    solve_lower(drift.factors[k], step)
    total = 0.0
    for i in range(mean.shape[0]):
        total += step[i] * step[i]
    return total


@njit
def judge_drift(belief: Belief, step):
    """Judge the belief by the kept ones, where enough was read since the last time, and keep it in its turn.

    ``step`` (p) is working memory.
    """
    drift = belief.drift
    if belief.readings < drift.judged + EVERY:
        return
    drift.judged = belief.readings
    for k in range(drift.kept):
        statistic = _squared_distance(drift, k, belief.mean, step)
        belief.misfit = max(belief.misfit, statistic / threshold(belief.mean.shape[0]))
    if is_due(belief):
        keep_belief(belief)


@njit
def is_due(belief: Belief):
    """Whether so much was read that the next belief is to be kept."""
    return belief.drift.kept < KEPT and belief.readings >= EVERY << belief.drift.kept


@njit
def keep_belief(belief: Belief):
    """Keep mean and covariance as they are."""
    drift = belief.drift
    drift.means[drift.kept, :] = belief.mean
    drift.factors[drift.kept, :, :] = belief.cov
    if decompose(drift.factors[drift.kept]):
        drift.kept += 1
