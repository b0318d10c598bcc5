"""Disagreement of a recording's parts beyond what their information allows: chi-squared of left-out groups."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jawenv.recordings.estimate import Array
from jawenv.recordings.untold.blocks import BLOCK_S, Blocks
from jawenv.recordings.untold.definite import factor
from jawenv.recordings.untold.law import bends, tensions

_TENTHS = 10
_CHANCE = 3.0
"""Sds of chi-squared by which it may exceed its degrees of freedom."""
_TELLING = 0.05
"""Share of a direction's variance that a left-out group must tell to be judged by it."""


@dataclass(frozen=True, eq=False)
class _Joint:
    """The most probable values of everything, and one prior sd of each number: p parameters, then all others."""

    values: Array  # (n,) of the columns, tensions from the point
    directions: Array  # (n, k) what each does to the columns


def joint_of(blocks: Blocks, theta: Array, sizes: Array, temperature: float) -> _Joint:
    """The joint mode under some sizes, at given parameters ``theta`` (p,)."""
    c, law = blocks.tensions, sizes[-1]
    total, score = blocks.information.sum(axis=0) / temperature, blocks.score.sum(axis=0) / temperature
    sds = blocks.sds(sizes[None])[0]
    shown = sds > 0.0
    laws = bends(blocks) if law > 0.0 else np.zeros((c, 0))
    others = np.zeros((len(score), shown.sum() + laws.shape[1]))
    others[c:, : shown.sum()], others[:c, shown.sum() :] = np.diag(sds)[:, shown], law * laws
    coefficients, by_log = tensions(blocks.basis, theta[None])
    moved, muscles = np.zeros(len(score)), np.zeros((len(score), by_log.shape[2]))
    moved[:c], muscles[:c] = coefficients[0] - blocks.nominal.ravel(), by_log[0] * blocks.prior_sd
    inner = others.T @ total @ others + np.eye(others.shape[1])
    values = moved + others @ np.linalg.solve(inner, others.T @ (score - total @ moved))
    return _Joint(values, np.column_stack([muscles, others]))


def disagreement(blocks: Blocks, joint: _Joint, groups: NDArray[np.intp], temperature: float) -> tuple[Array, Array]:
    """Chi-squared (G,) of each left-out group's word on the parameters against the rest's, and degrees of freedom."""
    parameters = len(blocks.point)
    left = blocks.score - blocks.information @ joint.values
    told, pulled = [], []
    for group in range(groups.max() + 1):
        chosen = groups == group
        inside = joint.directions.T @ blocks.information[chosen].sum(axis=0) @ joint.directions
        told.append(inside / temperature)
        pulled.append(joint.directions.T @ left[chosen].sum(axis=0) / temperature)
    whole = np.sum(told, axis=0) + np.eye(len(told[0]))
    last = np.roll(np.arange(len(whole)), -parameters)  # the parameters, so that their factor is of their own precision
    root = factor(whole[np.ix_(last, last)])[-parameters:, -parameters:].T
    squares, degrees = np.zeros(len(told)), np.zeros(len(told))
    eye = np.eye(len(whole))[:, :parameters]
    for k, (inside, score) in enumerate(zip(told, pulled, strict=True)):
        solved = np.linalg.solve(whole - inside, np.column_stack([eye, score]))[:parameters]
        wider = root @ solved[:, :parameters] @ root.T - np.eye(parameters)
        sizes, axes = np.linalg.eigh(0.5 * (wider + wider.T))
        away = axes.T @ root @ solved[:, parameters]
        telling = sizes > _TELLING
        squares[k], degrees[k] = np.sum(away[telling] ** 2 / sizes[telling]), telling.sum()
    return squares, degrees


def _groups_of_time(blocks: Blocks, number: int) -> NDArray[np.intp]:
    """(B,) group of each block, of so many equal stretches."""
    count = len(blocks.score)
    groups: NDArray[np.intp] = np.arange(count) * number // count
    return groups


def groups_of_poses(blocks: Blocks) -> NDArray[np.intp]:
    """(B,) group of each block, of ten sets of poses that lie together: means of Lloyd's kind."""
    places = blocks.poses * np.array([1.0, 1.0, 0.08, 0.08, 0.08])  # angles over the mouthpiece's arm
    number = min(_TENTHS, len(places))
    centres = places[np.argsort(places[:, 2])[np.linspace(0, len(places) - 1, number).astype(int)]]
    for _ in range(30):
        nearest = np.square(places[:, None] - centres).sum(axis=2).argmin(axis=1)
        of_any = [k for k in range(number) if np.any(nearest == k)]
        centres[of_any] = [places[nearest == k].mean(axis=0) for k in of_any]
    _, groups = np.unique(nearest, return_inverse=True)
    return groups.astype(np.intp)


def excess(blocks: Blocks, joint: _Joint, temperature: float) -> float:
    """Excess of chi-squared a degree of freedom over what chance makes, for the worst way to make groups.

    Groups are tenths of the time and of the poses, stretches of ten seconds, halves: what creeps lasts for long.
    """
    count = len(blocks.score)
    stretches = {min(_TENTHS, count), max(2, round(count * BLOCK_S / 10.0)), 2}
    ways = [_groups_of_time(blocks, number) for number in sorted(stretches)] + [groups_of_poses(blocks)]
    worst = 0.0
    for groups in ways:
        squares, degrees = disagreement(blocks, joint, groups, temperature)
        freedom = max(degrees.sum(), 1.0)
        worst = max(worst, float(squares.sum() / freedom - _CHANCE * np.sqrt(2.0 / freedom)))
    return worst
