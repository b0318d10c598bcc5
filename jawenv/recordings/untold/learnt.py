"""The belief at the end of a recording, with the sizes of errors that nobody told learnt from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from jawenv.anatomy import Prior
from jawenv.anatomy.knowledge import IMAGED
from jawenv.base.errors import InputError
from jawenv.mechanics.building import gravity_in_head
from jawenv.recordings.defaults import UNMODELLED_TIME, tilt_of
from jawenv.recordings.dividing import divided
from jawenv.recordings.estimate import Array
from jawenv.recordings.identification import Identification, identified
from jawenv.recordings.record import Record
from jawenv.recordings.untold.bank import LAWS, LEVELS, WEIGHED, Mixture, beforehand, mixture
from jawenv.recordings.untold.blocks import BLOCK_S, LATE_S, N_OF_DRIFT, N_OF_WRENCH, Blocks, blocks_of
from jawenv.recordings.untold.law import tensions
from jawenv.recordings.untold.shown import Shown, shown
from jawenv.recordings.untold.temperature import excess, joint_of

_ROUNDS, _ENOUGH = 4, 1.02
_BENT = 3.0  # largest ``Mixture.bend`` of a normal that becomes the belief
_MOVED = 0.1  # of a natural logarithm, from where the motion is linearised anew
_PASSES, _STAYED = 6, 0.5  # until what is far off stays where it is, in sds of a scan
_PITCHED = np.tile([1.0, 0.0, 0.0, 0.0, 10.0, 0.0], (len(LAWS), 1))
"""Sizes of a head of whose pitch nothing is known, and of no other error."""
_LYING = 5.0  # sds of the head's pitch beyond which it is looked whether the head is pitched so
_PITCH_SD_DEG = 20.0  # of a head that was found to be pitched so
_FEWEST = 10  # blocks of which groups can be left out
_LATE = -N_OF_WRENCH - 1  # column of how late forces are
_CONTRADICTION = (
    "errors that nobody told cannot be weighed, the readings contradict each other; allowed: one explanation"
)
_SHORT = f"errors that nobody told cannot be weighed; allowed: {_FEWEST * BLOCK_S:g} s or more, or --knowledge imaged"
INCONSISTENT = 1.5  # temperature from which parts disagree so much that the first word of gate and alarm stands


class JointBelief(NamedTuple):
    """Belief of parameters, ends of lines and bends of laws, under the most probable sizes."""

    cov: Array  # (p + k, p + k) of the natural logs and k unknowns, in sds
    moved: Array  # (2, k, lines, 3) m by which each of these moves origins and insertions
    bent: Array  # (1 + k, muscles, nodes) coefficients by which laws are bent, and what each unknown does to them
    basis: Any  # of the coefficients
    late_s: tuple[float, float]  # by which forces were written later than they were, and its sd


@dataclass(frozen=True, eq=False)
class Learnt:
    """A belief that integrates out errors whose sizes it has learnt."""

    mean: Array  # (p,) natural logs; the filter's own where no normal describes what the readings allow
    cov: Array  # (p, p) the same
    sizes: dict[str, float]  # the most probable, see ``bank.LEVELS``
    temperature: float  # what the information was divided by
    jaw: Any  # the record's, with ends of muscles and the head's tilt as the readings have them
    joint: JointBelief | None  # None where no normal describes what the readings allow
    shown: Shown  # the reasons, to be drawn
    rival: Array | None  # (p,) parameters that explain the readings as well, and that the belief excludes


def learnt(record: Record, mean: Array, cov: Array) -> Learnt | None:
    """The belief of a recording from the filter's last; None where nothing can be learnt of errors.

    The information is divided by a temperature until parts of the recording agree as they should. Errors that change
    over time raise it; for those that stay the bank has sizes.

    Args:
        record: the recording.
        mean: (p,) the filter's last belief.
        cov: (p, p) its covariance.
    """
    record = divided(record, max(1, round(record.dt / UNMODELLED_TIME)))
    blocks = blocks_of(record, mean)
    if len(blocks.score) < _FEWEST or not np.isfinite(blocks.information).all():
        return None
    found, temperature, spread = weighed(blocks)
    lying = _lying(record, blocks, found, temperature)
    if lying is not None:
        record, blocks, (found, temperature, spread) = lying
    unknowns = np.zeros(blocks.score.shape[1] - blocks.tensions)
    for _ in range(_PASSES):
        values = joint_of(blocks, found.best, found.sizes, temperature).values[blocks.tensions :]
        near = np.abs(found.best - blocks.point).max() <= _MOVED
        if near and np.abs(values - unknowns)[: -N_OF_WRENCH - N_OF_DRIFT].max() < _STAYED:
            break
        unknowns, blocks = values, blocks_of(record, found.best, values)
        found, temperature, spread = weighed(blocks)
    joint = None
    if found.bend(blocks) <= _BENT:
        mean, cov, joint = found.mean, spread * found.cov, _joint(blocks, found, temperature, spread)
    sizes, rival = dict(zip(LEVELS, found.sizes.tolist(), strict=True)), found.rival(blocks, mean, cov)
    jaw = _with_attachments(record.jaw, blocks, values) if sizes["lines"] > 1.0 else record.jaw
    return Learnt(mean, cov, sizes, temperature, jaw, joint, shown(blocks, found, temperature), rival)


def _joint(blocks: Blocks, found: Mixture, temperature: float, spread: float) -> JointBelief:
    """The belief of everything that moves lines or tensions under the most probable sizes."""
    joint, p, c = joint_of(blocks, found.best, found.sizes, temperature), len(found.best), blocks.tensions
    information = joint.directions.T @ blocks.information.sum(axis=0) @ joint.directions / temperature
    cov = spread * np.linalg.inv(information + np.eye(len(information)))
    others = joint.directions[:, p:]
    moved = np.einsum("nk,enlx->eklx", others[c:], blocks.by_end)
    estimated = np.flatnonzero(np.abs(moved).max(axis=(0, 2, 3)) + np.abs(others[:c]).max(axis=0) > 0.0)
    bends = joint.values[:c] + blocks.nominal.ravel() - tensions(blocks.basis, found.best[None])[0][0]
    bent = np.vstack([bends, others[:c, estimated].T]).reshape(-1, *blocks.nominal.shape)
    by_late = LATE_S * joint.directions[_LATE]
    late = float(LATE_S * joint.values[_LATE]), float(np.sqrt(by_late @ cov @ by_late))
    kept, units = np.append(np.arange(p), p + estimated), np.append(blocks.prior_sd, np.ones(len(estimated)))
    return JointBelief(units * cov[np.ix_(kept, kept)] * units[:, None], moved[:, estimated], bent, blocks.basis, late)


def _with_attachments(jaw: Any, blocks: Blocks, values: Array) -> Any:
    """A copy of the jaw with ends of muscles moved by ``values`` (n - c,) of the unknowns."""
    moved = jaw.copy()
    moved["origin"] += np.tensordot(values, blocks.by_end[0], 1)
    moved["insertion"] += np.tensordot(values, blocks.by_end[1], 1)
    moved["l_o"] = np.linalg.norm(moved["origin"] - moved["insertion"], axis=1)
    return moved


def _lying(
    record: Record, blocks: Blocks, found: Mixture, temperature: float
) -> tuple[Record, Blocks, tuple[Mixture, float, float]] | None:
    """The same for a head as the readings would have it pitched; None where that explains them no more simply.

    A head that lies back is many sds off, and gravity is not linear in its pitch.
    """
    before, told = found.sizes, IMAGED if record.knowledge.exact else record.knowledge  # as ``blocks_of`` has it
    for number in range(_PASSES):
        free = replace(blocks, attachments=blocks.tilt)  # the pitch alone may be far off, and all else is usual
        best = mixture(free, temperature, _PITCHED).best
        values = joint_of(free, best, _PITCHED[0], temperature).values[blocks.tensions :]
        tilt = float(values[blocks.tilt].sum())
        if abs(tilt) < (_LYING if number == 0 else _STAYED):
            break
        jaw, values[blocks.tilt] = record.jaw.copy(), 0.0
        pitch = tilt_of(jaw) + tilt * told.head_tilt_deg
        jaw["gravity"] = gravity_in_head(float(np.linalg.norm(jaw["gravity"])), pitch)
        record = replace(record, jaw=jaw)
        blocks = blocks_of(record, best, values)
    if number == 0:
        return None
    if not record.knowledge.exact:
        record = replace(record, knowledge=replace(record.knowledge, head_tilt_deg=_PITCH_SD_DEG))
        blocks = blocks_of(record, best, values)
    weighs = weighed(blocks)
    simpler, usual = beforehand(np.array([weighs[0].sizes, before]), WEIGHED)
    return (record, blocks, weighs) if simpler > usual else None


def weighed(blocks: Blocks) -> tuple[Mixture, float, float]:
    """The mixture, its temperature, and a factor of its covariance where parts do not agree after all rounds."""
    temperature = 1.0
    for _ in range(_ROUNDS):
        found = mixture(blocks, temperature)
        beyond = excess(blocks, joint_of(blocks, found.best, found.sizes, temperature), temperature)
        if beyond <= _ENOUGH:
            return found, temperature, 1.0
        temperature *= beyond
    return found, temperature, beyond


def identified_with_errors(record: Record) -> tuple[Identification, Learnt | None]:
    """The identification of a recording whose last belief has learnt the sizes of errors, and that belief."""
    found = identified(record)
    mean, cov = found.estimate.mean.copy(), found.estimate.cov.copy()
    try:
        last = learnt(record, mean[-1], cov[-1])
    except np.linalg.LinAlgError:  # of readings that no jaw makes
        return replace(found, rival=_CONTRADICTION), None
    if last is None:
        return (replace(found, rival=_SHORT) if record.knowledge.wrench_N else found), None
    agree = last.temperature < INCONSISTENT
    if last.jaw is not record.jaw or (agree and not found.believable):  # gate and alarm judge by what was learnt
        prior = Prior(last.mean, np.sqrt(np.diagonal(last.cov))) if agree else record.prior
        found = replace(identified(replace(record, jaw=last.jaw, prior=prior)), estimate=found.estimate)
    mean[-1], cov[-1] = last.mean, last.cov
    estimate = replace(found.estimate, mean=mean, cov=cov)
    return replace(found, estimate=estimate, rival=_in_words(record, last), temperature=last.temperature), last


def _in_words(record: Record, last: Learnt) -> str:
    """The parameter of the rival that differs most, in words; empty without a rival."""
    if last.rival is None:
        return ""
    first = int(np.abs(last.rival - last.mean).argmax())
    one, other = np.exp(last.mean[first]), np.exp(last.rival[first])
    name = record.parameter_names[first].removeprefix("log_")
    return f"{name}: {one:.3g} explains the readings, {other:.3g} as well; allowed: one explanation"


def learnt_beliefs(records: Sequence[Record] | None, means: Array, covs: Array) -> tuple[Array, Array]:
    """Means (N, p) and covariances (N, p, p) of N records; the filter's own where nothing can be learnt."""
    if records is None:
        raise InputError("records is None; allowed with untold: those of episodes with record=True")
    found = [learnt(*one) for one in zip(records, means, covs, strict=True)]
    own = zip(found, means, covs, strict=True)
    beliefs = [(mean, cov) if one is None else (one.mean, one.cov) for one, mean, cov in own]
    return np.array([mean for mean, _ in beliefs]), np.array([cov for _, cov in beliefs])
