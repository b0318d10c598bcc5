"""The belief at the end of a recording, with the sizes of errors that nobody told learnt from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from jawenv.base.errors import InputError
from jawenv.recordings.defaults import UNMODELLED_TIME
from jawenv.recordings.estimate import Array
from jawenv.recordings.identification import Identification, identified
from jawenv.recordings.record import Record
from jawenv.recordings.thinning import divided
from jawenv.recordings.untold.bank import Mixture, mixture
from jawenv.recordings.untold.blocks import Blocks, blocks_of
from jawenv.recordings.untold.shown import Shown, shown
from jawenv.recordings.untold.temperature import excess, joint_of

_ROUNDS, _ENOUGH = 4, 1.02
_BENT = 3.0
"""Largest ``Mixture.bend`` of a normal that becomes the belief."""
_MOVED = 0.1  # of a natural logarithm, from where the motion is linearised anew
_FEWEST = 10
"""Blocks of which groups can be left out."""
_CONTRADICTION = "errors that nobody told cannot be weighed, the readings contradict each other"


@dataclass(frozen=True, eq=False)
class Learnt:
    """A belief that integrates out errors whose sizes it has learnt."""

    mean: Array  # (p,) natural logs; the filter's own where no normal describes what the readings allow
    cov: Array  # (p, p) the same
    sizes: Array  # (5,) the most probable, see ``bank.SIZES``
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
    if np.abs(found.best - blocks.point).max() > _MOVED:
        values = joint_of(blocks, found.best, found.sizes, temperature).values
        blocks = blocks_of(record, found.best, values[blocks.tensions :])
        found, temperature, spread = weighed(blocks)
    if found.bend(blocks) <= _BENT:
        mean, cov = found.mean, spread * found.cov
    return Learnt(mean, cov, found.sizes, shown(blocks, found, temperature), found.rival(blocks, mean, cov))


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
        return found, None
    mean[-1], cov[-1] = last.mean, last.cov
    estimate = replace(found.estimate, mean=mean, cov=cov)
    return replace(found, estimate=estimate, rival=_in_words(record, last)), last


def _in_words(record: Record, last: Learnt) -> str:
    """The parameter of the rival that differs most, in words; empty without a rival."""
    if last.rival is None:
        return ""
    first = int(np.abs(last.rival - last.mean).argmax())
    one, other = np.exp(last.mean[first]), np.exp(last.rival[first])
    return f"{record.parameter_names[first].removeprefix('log_')}: {one:.3g} explains the readings, {other:.3g} as well"


def learnt_beliefs(records: Sequence[Record] | None, means: Array, covs: Array) -> tuple[Array, Array]:
    """Means (N, p) and covariances (N, p, p) of N records; the filter's own where nothing can be learnt."""
    if records is None:
        raise InputError("records is None; allowed with untold: those of episodes with record=True")
    found = [learnt(*one) for one in zip(records, means, covs, strict=True)]
    own = zip(found, means, covs, strict=True)
    beliefs = [(mean, cov) if one is None else (one.mean, one.cov) for one, mean, cov in own]
    return np.array([mean for mean, _ in beliefs]), np.array([cov for _, cov in beliefs])
