"""Update of the belief about the parameters from all information so far."""

from __future__ import annotations

from typing import Any

from jawenv.filter.basis import N_NODES, set_coefficients
from jawenv.filter.posterior import posterior_dtype, update_belief
from jawenv.filter.refocus import refocus
from jawenv.filter.state import tension_columns
from jawenv.kernels.compiled import njit


def belief_fields(n_muscles: int) -> list[Any]:
    """Fields of the working memory of ``learn``."""
    return [
        ("posterior", posterior_dtype(n_muscles)),
        ("after", "f8", (n_muscles, N_NODES)),
        ("row", "f8", (tension_columns(n_muscles),)),
        ("carried", "f8", (N_NODES, N_NODES)),
    ]


@njit
def recentre(belief, scratch):
    """Move motion and score to the belief's mean."""
    nodes = belief.nominal.shape[1]
    set_coefficients(belief.basis, belief.mean, scratch.after)
    row = scratch.row
    row[:] = 0.0
    for i in range(belief.nominal.shape[0]):
        for k in range(nodes):
            row[i * nodes + k] = scratch.after[i, k] - belief.nominal[i, k]
    for i in range(belief.motion.shape[0]):
        for j in range(row.shape[0]):
            belief.motion[i] += belief.by_tension[i, j] * row[j]
    for i in range(row.shape[0]):
        for j in range(row.shape[0]):
            belief.score[i] -= belief.information[i, j] * row[j]
    belief.nominal[:, :] = scratch.after


@njit
def learn(belief, settings, scratch):
    """The belief about the parameters from all information so far; motion and score move to its mean."""
    update_belief(belief, settings, scratch.posterior)
    recentre(belief, scratch)
    refocus(belief, scratch)
