"""Update of the belief about the parameters from all information so far."""

from __future__ import annotations

from functools import cache
from typing import Annotated

import numpy as np

from jawenv.filter.alarm.drift import judge_drift, keep_belief
from jawenv.filter.alarm.misfit import move_block
from jawenv.filter.belief.posterior import PosteriorScratch, posterior_dtype, update_belief
from jawenv.filter.belief.refocus import refocus
from jawenv.filter.belief.state import FARTHEST, Belief, FilterSettings, tension_columns
from jawenv.filter.model.basis import N_NODES, set_coefficients
from jawenv.filter.nuisances.if_any import move_nuisances
from jawenv.kernels.cholesky import solve_decomposed
from jawenv.kernels.compiled import njit
from jawenv.kernels.records import Array, record_dtype


class LearnScratch:
    """Working memory of ``learn``."""

    posterior: PosteriorScratch
    after: Annotated[Array, "muscles", N_NODES]
    row: Annotated[Array, "columns"]
    carried: Annotated[Array, N_NODES, N_NODES]
    step: Annotated[Array, "parameters"]


@cache
def learn_scratch_dtype(n_muscles: int, n_nuisances: int = 0) -> np.dtype[np.void]:
    """Dtype of ``LearnScratch``."""
    return record_dtype(
        LearnScratch,
        posterior=posterior_dtype(n_muscles, n_nuisances),
        muscles=n_muscles,
        columns=tension_columns(n_muscles, n_nuisances),
        parameters=2 * n_muscles,
    )


@njit
def set_steps(belief: Belief, scratch: LearnScratch):
    """Into ``row`` (columns) how far coefficients and nuisances of the belief's mean are from its point.

    The nuisances are the most probable ones at the new tensions, and none goes beyond ``FARTHEST``, where a model is
    none any more. The gain error is where it is: its score stands for its mean.
    """
    nodes = belief.nominal.shape[1]
    set_coefficients(belief.basis, belief.mean, scratch.after)
    row = scratch.row
    row[:] = 0.0
    for i in range(belief.nominal.shape[0]):
        for k in range(nodes):
            row[i * nodes + k] = scratch.after[i, k] - belief.nominal[i, k]
    first, pulled = belief.nominal.shape[0] * nodes, scratch.posterior.pulled_nuisances
    if belief.nuisances.shape[0] == 0:
        return
    for k in range(pulled.shape[0]):
        value = belief.score[first + k] - (belief.nuisances[k - 1] if k > 0 else 0.0)
        for j in range(first):
            value -= belief.information[first + k, j] * row[j]
        pulled[k] = value
    solve_decomposed(belief.nuisance_factor, pulled)
    for k in range(1, pulled.shape[0]):
        before = belief.nuisances[k - 1]
        row[first + k] = min(max(before + pulled[k], -FARTHEST), FARTHEST) - before


@njit
def recentre(belief: Belief, settings: FilterSettings, scratch: LearnScratch):
    """Move motion and score to the belief's mean.

    Beside a disturbance with memory, what a jaw at rest does not show stays nominal (``changes.separates_statics``).
    """
    set_steps(belief, scratch)
    row = scratch.row
    move_nuisances(belief, settings, row, belief.nominal.shape[0] * belief.nominal.shape[1] + 1)
    for i in range(belief.motion.shape[0]):
        for j in range(row.shape[0]):
            belief.motion[i] += belief.by_tension[i, j] * row[j]
    for i in range(row.shape[0]):
        for j in range(row.shape[0]):
            belief.score[i] -= belief.information[i, j] * row[j]
    belief.nominal[:, :] = scratch.after
    belief.point[:] = belief.mean
    belief.steps[:] = 0.0
    move_block(belief.block, row)


@njit
def learn(belief: Belief, settings: FilterSettings, scratch: LearnScratch):
    """The belief about the parameters from all information so far; motion and score move to its mean."""
    update_belief(belief, settings, scratch.posterior)
    recentre(belief, settings, scratch)
    refocus(belief, scratch)
    judge_drift(belief, scratch.step)


@njit
def keep_passing(belief: Belief, settings: FilterSettings, scratch: LearnScratch):
    """Keep, for ``drift``, what the readings so far teach; the belief stays."""
    if update_belief(belief, settings, scratch.posterior):
        keep_belief(belief)
        belief.mean[:] = scratch.posterior.last_mean
        belief.cov[:, :] = scratch.posterior.last_cov


@njit
def conclude(belief: Belief, settings: FilterSettings, scratch: LearnScratch):
    """The belief about the parameters from all information so far; the point of linearisation stays.

    Readings that are linearised about points that follow their own noise teach what they do not know: directions that
    no reading tells apart at one point look different at each (Huang, Mourikis & Roumeliotis 2010, Int. J. Robot. Res.
    29:502). So the point moves where the readings are filtered again, and with a surprise.
    """
    if update_belief(belief, settings, scratch.posterior):
        set_steps(belief, scratch)
        belief.steps[:] = scratch.row
    judge_drift(belief, scratch.step)
