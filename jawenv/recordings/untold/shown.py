"""Signs of errors that nobody told: the wrench that no muscle pulls, and how left-out poses disagree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jawenv.filter.nuisances.unknowns import WRENCH_UNITS
from jawenv.recordings.estimate import Array
from jawenv.recordings.untold.bank import Mixture
from jawenv.recordings.untold.blocks import N_OF_WRENCH, Blocks
from jawenv.recordings.untold.temperature import disagreement, groups_of_poses, joint_of

_OPENINGS = 25  # at which the wrench is shown


@dataclass(frozen=True, eq=False)
class Shown:
    """Force that no muscle pulls along the opening, and how much a recording's parts disagree."""

    temperature: float  # what the information was divided by
    opening: Array  # (K,) rad
    force: Array  # (K, 3) N in body axes: forwards, to the left, up
    force_sd: Array  # (K, 3)
    pose_opening: Array  # (G,) rad, mean of each left-out group
    disagreement: Array
    """(G,) chi-squared a degree of freedom of each, before the information is divided: 1 where all is as believed."""


def shown(blocks: Blocks, found: Mixture, temperature: float) -> Shown:
    """Both, with sizes that are the root mean squares of the mixture's."""
    sizes = np.sqrt(found.weights @ found.every**2)
    joint = joint_of(blocks, found.best, sizes, temperature)
    told = joint.directions.T @ blocks.information.sum(axis=0) @ joint.directions / temperature
    rows = joint.directions[-N_OF_WRENCH:]
    cov = rows @ np.linalg.inv(told + np.eye(len(told))) @ rows.T
    pitch, x = blocks.poses[:, 2], blocks.poses[:, 0]
    opening = np.linspace(pitch.min(), pitch.max(), _OPENINGS)
    by_opening = (pitch - pitch.mean()) @ x / max(np.sum(np.square(pitch - pitch.mean())), 1e-12)
    slide = x.mean() + by_opening * (opening - pitch.mean())
    wide, zero = opening / 0.2, np.zeros(_OPENINGS)
    shapes = np.stack([zero + 1.0, wide, wide**2, slide / 5e-3, zero, zero], axis=1)  # as ``filter.nuisances.turned``
    force, sd = np.empty((_OPENINGS, 3)), np.empty((_OPENINGS, 3))
    for k in range(3):
        chosen = np.arange(k, N_OF_WRENCH, len(WRENCH_UNITS))
        force[:, k] = shapes @ joint.values[-N_OF_WRENCH:][chosen]
        sd[:, k] = np.sqrt(np.einsum("ks,st,kt->k", shapes, cov[np.ix_(chosen, chosen)], shapes))
    groups = groups_of_poses(blocks)
    squares, degrees = disagreement(blocks, joint_of(blocks, found.best, found.sizes, 1.0), groups, 1.0)
    telling = degrees > 0
    means = np.bincount(groups, weights=blocks.poses[:, 2]) / np.bincount(groups)
    return Shown(temperature, opening, force, sd, means[telling], squares[telling] / degrees[telling])
