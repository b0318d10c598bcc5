"""One belief of several recordings of a patient: muscles and anatomy are the same, each mounting is another.

The blocks of all recordings stand beside each other: the columns of the tensions and of the patient's own anatomy are
shared, those of the session (gain, offset, mouthpiece, tilt, the wrench of no muscle) are each recording's. Sizes of
errors are learnt from all of them at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from jawenv.anatomy import Prior
from jawenv.base.errors import InputError
from jawenv.recordings.defaults import UNMODELLED_TIME
from jawenv.recordings.dividing import divided
from jawenv.recordings.estimate import Array
from jawenv.recordings.record import Record
from jawenv.recordings.untold.blocks import MOST_BLOCKS, Blocks, blocks_of
from jawenv.recordings.untold.learnt import weighed
from jawenv.recordings.untold.temperature import joint_of

MOST = 8
"""Recordings: the numbers that are integrated out grow with each."""
_PASSES = 2
_LEAST_P = 1e-6
"""Chance below which two recordings are not of one patient."""
_TELLING = 1e-3
"""Share of the prior's variance by which the difference of two beliefs must be able to vary to be judged."""


@dataclass(frozen=True)
class Agreement:
    """Chi-squared of the two recordings whose beliefs agree least."""

    pair: tuple[int, int]  # numbers of the two
    squares: float
    degrees: int
    p: float  # chance of as much between two recordings of one patient, whichever two
    parameter: int  # that differs most in sds

    @property
    def one_patient(self) -> bool:
        """Whether all recordings may be of one patient."""
        return self.p >= _LEAST_P


def combined(before: tuple[Array, Array], working: Prior, mean: Array, cov: Array) -> tuple[Array, Array]:
    """The full belief at each of T times, where a filter began with a working prior in the full belief's place.

    Args:
        before: mean (P,) and covariance of the full belief before.
        working: prior of the filter's run.
        mean: (T, P) of the filter.
        cov: (T, P, P) of the filter.

    Returns:
        (T, P) means and (T, P, P) covariances.
    """
    at_start, prior_information = np.linalg.inv(before[1]), 1.0 / np.square(working.sd)
    gained = np.linalg.inv(cov)
    precision = at_start + gained - np.diag(prior_information)
    # Means as steps from the working prior's, so that nothing large is subtracted.
    steps = np.einsum("tij,tj->ti", gained, mean - working.mean) + at_start @ (before[0] - working.mean)
    covariance = np.linalg.inv(precision)
    covariance = 0.5 * (covariance + np.swapaxes(covariance, -1, -2))
    return working.mean + np.einsum("tij,tj->ti", covariance, steps), covariance


def agreement(prior: Prior, means: Array, covs: Array) -> Agreement:
    """Whether the beliefs (N, p) and (N, p, p) of N recordings, each from the same prior, can be of one patient.

    With P_0 the prior's covariance, and P_i the belief's, the mean m_i varies by P_0 - P_i over patients, and with m_j
    by (P_0 - P_i) P_0^-1 (P_0 - P_j). Errors of the anatomy, which both share, make the difference smaller.
    """
    pairs = [(i, j) for j in range(len(means)) for i in range(j)]
    found = [_between(prior, means[[i, j]], covs[[i, j]], (i, j), len(pairs)) for i, j in pairs]
    return min(found, key=lambda one: (one.p, -one.squares))


def _between(prior: Prior, means: Array, covs: Array, pair: tuple[int, int], pairs: int) -> Agreement:
    one, other = np.diag(prior.sd**2) - covs
    shared = one / prior.sd**2 @ other
    variance = (one + other - shared - shared.T) / np.outer(prior.sd, prior.sd)
    away = (means[1] - means[0]) / prior.sd
    sizes, axes = np.linalg.eigh(variance)
    telling = sizes > _TELLING
    squares = float(np.sum((axes.T @ away)[telling] ** 2 / sizes[telling]))
    degrees = int(telling.sum())
    p = min(1.0, pairs * float(chi2.sf(squares, degrees))) if degrees else 1.0
    sd = np.sqrt(np.maximum(np.diagonal(variance), _TELLING))
    return Agreement(pair, squares, degrees, p, int(np.argmax(np.abs(away) / sd)))


@dataclass(frozen=True, eq=False)
class _Several(Blocks):
    """The blocks of several recordings, by the columns of all."""

    parts: tuple[Blocks, ...]
    places: tuple[NDArray[np.intp], ...]  # where the columns of each are among those of all

    def sds(self, sizes: Array) -> Array:
        """(N, n - c) prior sds of the columns behind the tensions under N sizes."""
        found = np.zeros((len(sizes), self.score.shape[1] - self.tensions))
        for part, place in zip(self.parts, self.places, strict=True):
            found[:, place[self.tensions :] - self.tensions] = part.sds(sizes)
        return found

    @classmethod
    def of(cls, parts: Sequence[Blocks]) -> _Several:
        """Join the blocks of recordings whose motion is linearised about the same muscles."""
        first, places, count = parts[0], list[NDArray[np.intp]](), parts[0].tensions + int(parts[0].own.sum())
        for part in parts:
            session = int((~part.own).sum())
            place = np.empty(len(part.own), dtype=np.intp)
            place[part.own] = first.tensions + np.arange(part.own.sum())
            place[~part.own] = count + np.arange(session)
            places.append(np.concatenate([np.arange(first.tensions), place]))
            count += session
        blocks = sum(len(part.score) for part in parts)
        information, score, row = np.zeros((blocks, count, count)), np.zeros((blocks, count)), 0
        for part, place in zip(parts, places, strict=True):
            rows = slice(row, row + len(part.score))
            information[rows, place[:, None], place], score[rows, place] = part.information, part.score
            row = rows.stop
        whole = {name: getattr(first, name) for name in Blocks.__dataclass_fields__}
        whole |= {"information": information, "score": score, "own": np.zeros(count - first.tensions, dtype=bool)}
        nothing = np.zeros(count - first.tensions, dtype=bool)
        whole |= {"attachments": nothing, "tilt": nothing}  # sds are those of the parts
        poses = np.concatenate([part.poses for part in parts])
        return cls(**(whole | {"poses": poses}), parts=tuple(parts), places=tuple(places))


def together(records: Sequence[Record], mean: Array) -> tuple[Array, Array]:
    """Mean (p,) and covariance (p, p) of the belief about the patient of several recordings.

    Args:
        records: two or more, from the same prior and with the same knowledge.
        mean: (p,) about which the motion is linearised first.
    """
    _check(records)
    records = [divided(record, max(1, round(record.dt / UNMODELLED_TIME))) for record in records]
    unknowns: list[Array | None] = [None] * len(records)
    for _ in range(_PASSES):
        given = zip(records, unknowns, strict=True)
        parts = [_fewer(blocks_of(record, mean, values), len(records)) for record, values in given]
        blocks = _Several.of(parts)
        found, temperature, spread = weighed(blocks)
        mean = found.best
        values = joint_of(blocks, mean, found.sizes, temperature).values
        unknowns = [values[place][blocks.tensions :] for place in blocks.places]
    return found.mean, spread * found.cov


def _fewer(blocks: Blocks, number: int) -> Blocks:
    """The same in so few blocks that those of ``number`` recordings fit into memory."""
    every = -(-len(blocks.score) * 2 * number // MOST_BLOCKS)
    if every < 2:
        return blocks
    starts = np.arange(0, len(blocks.score), every)
    last = np.append(starts[1:], len(blocks.score)) - 1
    information, score = (np.add.reduceat(sums, starts, axis=0) for sums in (blocks.information, blocks.score))
    return replace(blocks, information=information, score=score, poses=blocks.poses[last])


def _check(records: Sequence[Record]) -> None:
    """The recordings are of one model and one prior, and of an anatomy that is known equally well."""
    if not 2 <= len(records) <= MOST:
        raise InputError(f"{len(records)} recordings; allowed: 2 to {MOST}")
    first = records[0]
    for record in records[1:]:
        same = {
            "model": record.parameter_names == first.parameter_names
            and len(record.start_mean) == len(first.start_mean),
            "prior": np.array_equal(record.prior.mean, first.prior.mean)
            and np.array_equal(record.prior.sd, first.prior.sd),
            "knowledge": record.knowledge == first.knowledge,
            "force sensor": record.force_sensor == first.force_sensor,
        }
        if other := next((name for name, alike in same.items() if not alike), None):
            raise InputError(f"recordings differ in their {other}; allowed: one for all (--cohort, --knowledge)")
