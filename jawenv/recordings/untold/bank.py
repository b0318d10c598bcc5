"""Sizes of errors that nobody told, each weighed by its evidence: a scan's, a wrench, a drift, lines, bent laws.

For every six sizes all unknowns are integrated out in closed form but the muscles' parameters, about whose most
probable values a normal belief is laid (Laplace). Beforehand 0.9 of the weight is on a size of zero, also of a wrench
that the filter was told of: a fixed sd of 0.1 N would double the error bars of recordings that need none. Lines of
muscles are usually those of the mean anatomy, but where a scan is told of: then all sizes are alike.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from jawenv.recordings.estimate import Array
from jawenv.recordings.untold.blocks import Blocks
from jawenv.recordings.untold.definite import factor
from jawenv.recordings.untold.law import bends, tensions

LAWS = (0.0, 0.03, 0.1, 0.3)
LEVELS = {
    "scan": (0.0, 1.0),  # share of a scan's sds
    "constant": (0.0, 0.1, 0.3),  # sd of a wrench's constants, N
    "shapes": (0.0, 0.1, 1.0),  # of its other shapes, N
    "drift": (0.0, 1.0),  # of the cell's zero over a third of the recording, N
    "lines": (1.0, 3.0, 10.0),  # sds of attachments over a scan's: 10 is the table's mean anatomy
    "law": LAWS,  # sd of bends, share of a tension
}
"""Name of each size -> its levels; the first is the usual one, of lines the last."""
SIZES = np.array([sizes for sizes in product(*LEVELS.values()) if sizes[0] > 0.0 or sizes[4] == 1.0])
"""(288, 6) sizes; laws vary first."""
_USUAL = 0.9
WEIGHED = [name for name in LEVELS if name != "lines"]
_EFFORT, _LONG = (12, 6), (80, 14)
"""Steps of Newton's method and halvings of each; from an exchange of muscles the way is longer."""
_ENOUGH = 1e-4
_NEAR, _FAR = 5.0, 10.0
"""Largest distance of another named explanation below the most probable one, nats; least distance from a belief, in sds
squared over the number of parameters.
"""
_DRAWS = 400


@dataclass(frozen=True, eq=False)
class Mixture:
    """The beliefs under all sizes together."""

    mean: Array  # (p,)
    cov: Array  # (p, p)
    weights: Array  # (N,) of the sizes
    best: Array  # (p,) the mean under the most probable sizes
    sizes: Array  # (6,) these
    every: Array  # (N, 6) all sizes
    information: Array  # (c, c) about the tensions under the most probable sizes
    score: Array  # (c,) the same

    def bend(self, blocks: Blocks) -> float:
        """Fall of the probability at draws of the normal, over the normal's own; in the median, 1 where it is normal.

        Where single muscles are hardly told apart, what the readings allow is a bent valley and no ellipsoid.
        """
        draws = np.random.default_rng(0).standard_normal((_DRAWS, len(self.best)))
        by_log = tensions(blocks.basis, self.best[None])[1][0]
        precision = by_log.T @ self.information @ by_log + np.diag(1.0 / blocks.prior_sd**2)
        away = np.linalg.solve(factor(precision).T, draws.T).T
        height, top = (self._height(blocks, theta) for theta in (self.best + away, self.best[None]))
        return float(np.median((top - height) / (0.5 * np.sum(draws**2, axis=1))))

    def rival(self, blocks: Blocks, mean: Array, cov: Array) -> Array | None:
        """The most probable parameters (p,) that the readings allow and a belief excludes; None where there are none.

        Looked for from each exchange of two muscles.
        """
        muscles = len(self.best) // 2
        starts = np.tile(self.best, (1 + muscles * (muscles - 1) // 2, 1))
        for start, (one, other) in zip(starts[1:], combinations(range(muscles), 2), strict=True):
            start.reshape(-1, 2)[[one, other]] = start.reshape(-1, 2)[[other, one]]
        information, score = (np.repeat(part[None], len(starts), axis=0) for part in (self.information, self.score))
        modes, _, heights = _most_probable(blocks, information, score, starts, _LONG)
        away = modes - mean
        far = np.einsum("ni,ij,nj->n", away, np.linalg.inv(cov), away) / len(mean)
        allowed = (far > _FAR) & (heights > heights.max() - _NEAR)
        return modes[np.where(allowed, heights, -np.inf).argmax()] if allowed.any() else None

    def _height(self, blocks: Blocks, theta: Array) -> Array:
        moved, away = tensions(blocks.basis, theta)[0] - blocks.nominal.ravel(), (theta - blocks.prior_mean)
        pulled = self.score - 0.5 * moved @ self.information
        reached: Array = np.sum(pulled * moved, axis=1) - 0.5 * np.sum((away / blocks.prior_sd) ** 2, axis=1)
        return reached


def mixture(blocks: Blocks, temperature: float, sizes: Array | None = None) -> Mixture:
    """The belief about the muscles, whatever the sizes are; of ``SIZES``, or of others whose laws vary first."""
    if sizes is None:
        sizes = SIZES[SIZES[:, 0] == 1.0] if blocks.scan_assumed else SIZES
    information, score, evidence = _about_tensions(blocks, temperature, sizes)
    means, covs, heights = _most_probable(blocks, information, score, np.tile(blocks.point, (len(score), 1)))
    weights = evidence + heights + beforehand(sizes, LEVELS if blocks.wrench_assumed else WEIGHED)  # of a bench
    weights = np.where(np.isfinite(weights), weights, -np.inf)
    weights = np.exp(weights - weights.max())
    weights /= weights.sum()
    used = weights > 0.0
    mean = weights[used] @ means[used]
    away = means[used] - mean
    cov = np.einsum("n,nij->ij", weights[used], covs[used] + away[:, :, None] * away[:, None, :])
    first = int(weights.argmax())
    best = means[first], sizes[first], sizes, information[first], score[first]
    return Mixture(mean, 0.5 * (cov + cov.T), weights, *best)


def beforehand(sizes: Array, kinds: Collection[str]) -> Array:
    """(N,) logarithms of the weights of these kinds before anything is read, also of a wrench that was told."""
    weights = np.zeros(len(sizes))
    for j, (name, levels) in enumerate(LEVELS.items()):
        if name in kinds:
            usual = levels[-1] if name == "lines" else levels[0]
            weights += np.where(sizes[:, j] == usual, np.log(_USUAL), np.log((1.0 - _USUAL) / (len(levels) - 1)))
    return weights


def _about_tensions(blocks: Blocks, temperature: float, sizes: Array) -> tuple[Array, Array, Array]:
    """Information (N, c, c) and score (N, c) about the tensions under N sizes, and logarithms (N,) of their weights."""
    c = blocks.tensions
    total, score = blocks.information.sum(axis=0) / temperature, blocks.score.sum(axis=0) / temperature
    sds = blocks.sds(sizes[:: len(LAWS)])[:, :, None]
    shared = sds * np.column_stack([total[c:, :c], score[c:]])
    parts = _without(sds * total[c:, c:] * np.swapaxes(sds, 1, 2), shared, total[:c, :c], score[:c])
    information, pulled, evidence = (np.repeat(part, len(LAWS), axis=0) for part in parts)
    bent = sizes[:, -1, None, None] * bends(blocks).T
    turned = bent @ information
    shared = np.concatenate([turned, bent @ pulled[:, :, None]], axis=2)
    information, pulled, more = _without(turned @ np.swapaxes(bent, 1, 2), shared, information, pulled)
    return information, pulled, evidence + more


def _without(inner: Array, shared: Array, left: Array, right: Array) -> tuple[Array, Array, Array]:
    """Information and score with k numbers of prior N(0, 1) integrated out, and the logarithm of what that weighs.

    Args:
        inner: (N, k, k) information about them.
        shared: (N, k, c + 1) what they share with the others, and behind it their score.
        left: (..., c, c) information about the others.
        right: (..., c) its score.
    """
    root = factor(0.5 * (inner + np.swapaxes(inner, 1, 2)) + np.eye(inner.shape[1]))
    whitened = np.linalg.solve(root, shared)
    rows, column = whitened[:, :, :-1], whitened[:, :, -1]
    information = left - np.swapaxes(rows, 1, 2) @ rows
    score = right - np.einsum("nkc,nk->nc", rows, column)
    evidence = 0.5 * np.sum(column**2, axis=1) - np.log(np.diagonal(root, axis1=1, axis2=2)).sum(axis=1)
    return 0.5 * (information + np.swapaxes(information, 1, 2)), score, evidence


def _most_probable(
    blocks: Blocks, information: Array, score: Array, theta: Array, effort: tuple[int, int] = _EFFORT
) -> tuple[Array, Array, Array]:
    """Means (N, p) and covariances (N, p, p) of the parameters by Newton's method, and the logarithm of the weight.

    Args:
        blocks: of the recording.
        information: (N, c, c) about the tensions.
        score: (N, c) the same.
        theta: (N, p) where it begins.
        effort: steps, and halvings of each.
    """
    nominal, prior = blocks.nominal.ravel(), np.diag(1.0 / blocks.prior_sd**2)

    def height(theta: Array) -> Array:
        with np.errstate(all="ignore"):
            moved, away = tensions(blocks.basis, theta)[0] - nominal, theta - blocks.prior_mean
            pulled = score - 0.5 * np.einsum("nij,nj->ni", information, moved)
            reached: Array = np.sum(pulled * moved, axis=1) - 0.5 * np.sum(away @ prior * away, axis=1)
            return reached

    now = height(theta)
    for _ in range(effort[0]):
        moved, by_log = tensions(blocks.basis, theta)
        pulled = score - np.einsum("nij,nj->ni", information, moved - nominal)
        gradient = np.einsum("ncp,nc->np", by_log, pulled) - (theta - blocks.prior_mean) @ prior
        precision = np.swapaxes(by_log, 1, 2) @ information @ by_log + prior
        step = np.linalg.solve(precision, gradient[:, :, None])[:, :, 0]
        step /= np.maximum(np.abs(step).max(axis=1), 1.0)[:, None]
        share = np.ones(len(theta))
        for _ in range(effort[1]):
            then = height(theta + share[:, None] * step)
            worse = ~(then >= now - 1e-9)
            if not worse.any():
                break
            share[worse] *= 0.5
        share[worse], then = 0.0, np.where(worse, now, then)
        theta, gained, now = theta + share[:, None] * step, then - now, then
        if gained.max() < _ENOUGH:
            break
    by_log = tensions(blocks.basis, theta)[1]
    precision = np.swapaxes(by_log, 1, 2) @ information @ by_log + prior
    heights: Array = now - 0.5 * np.linalg.slogdet(precision)[1]
    return theta, np.asarray(np.linalg.inv(precision)), heights
