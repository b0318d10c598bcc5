"""Information of each half second of a recording on muscles and other unknowns, along one fixed belief's motion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy.knowledge import IMAGED
from jawenv.filter.belief.refocus import refocus
from jawenv.filter.belief.state import (
    FARTHEST,
    N_SHAPES,
    Belief,
    FilterSettings,
    begin_motion,
    belief_dtype,
    forget_readings,
)
from jawenv.filter.model.basis import N_NODES
from jawenv.filter.nuisances.changed_jaw import move_jaw
from jawenv.filter.nuisances.unknowns import WRENCH_UNITS
from jawenv.filter.tick import ROW, FilterScratch, begin_filter, filter_scratch_dtype, read_row, take_readings
from jawenv.kernels.compiled import njit
from jawenv.kernels.records import record_zeros
from jawenv.mechanics.jaw import Jaw
from jawenv.recordings.estimate import Array
from jawenv.recordings.filter_settings import settings_of_record
from jawenv.recordings.record import Record

BLOCK_S = 0.5
MOST_BLOCKS = 600  # of a recording: those of an hour would fill the memory, so they are longer
_WIDTH = 0.2  # sd of log b that the basis of tensions spans: of narrower ones no bend of a law can be made
_N_CONSTANT = len(WRENCH_UNITS)
_OF_A_SESSION = ("gravity", "tone", "mouthpiece", "zero", "offset", "turn", "cell_turn", "of_motors", "again")
"""Each mounting draws the unknowns of these effects anew; all others are the patient's own."""
N_OF_WRENCH = N_SHAPES * _N_CONSTANT
"""Numbers of the wrench that no muscle pulls: first those that are constant, then those of the other shapes."""
_STRETCHES = 3  # of a recording, over each of which the load cell's zero may drift by a number of its own
LATE_S = 0.04  # sd of how late forces were written
N_OF_DRIFT = _STRETCHES * _N_CONSTANT + 1  # the last is how late
_MOST_ATTACHMENTS = 30.0  # sds of a scan by which an end may be off, as the table's are
_LINEAR = 1.2  # prior sds of another unknown from its nominal value within which the motion is linearised


@dataclass(frozen=True, eq=False)
class Blocks:
    """The log-likelihood of B blocks, quadratic in n columns: tensions, gain, other unknowns, drift and delay, wrench.

    The c columns of tensions count from the point, all others from 0.
    """

    information: Array  # (B, n, n)
    score: Array  # (B, n)
    poses: Array  # (B, 5) at their ends
    own: NDArray[np.bool_]  # (n - c,) which columns behind the tensions are the patient's own
    attachments: NDArray[np.bool_]  # (n - c,) which of them move these
    tilt: NDArray[np.bool_]  # (n - c,) which one turns gravity
    by_end: Array  # (2, n - c, lines, 3) m by which each of them moves origins and insertions
    gain_sd: float  # of the load cell's gain error
    scan_assumed: bool  # whether the filter knew of the other unknowns: then their sds are those that it has
    wrench_assumed: float  # sd of the wrench that it knew of, N
    point: Array  # (p,) natural-log parameters about which the motion is linearised
    basis: Any  # of the tensions
    nominal: Array  # (muscles, nodes) coefficients at the point
    prior_mean: Array  # (p,)
    prior_sd: Array  # (p,)

    @property
    def tensions(self) -> int:
        """Number of columns that are of tensions."""
        return self.nominal.size

    def sds(self, sizes: Array) -> Array:
        """(N, n - c) prior sds of the columns behind the tensions under N sizes, see ``bank.SIZES``."""
        others = self.score.shape[1] - self.tensions - 1 - N_OF_DRIFT - N_OF_WRENCH
        scan, constant, shapes, drift, ends = (sizes[:, j, None] for j in range(5))
        gain = np.full((len(sizes), 1), self.gain_sd)
        known = np.repeat(np.ones_like(scan) if self.scan_assumed else scan, others, axis=1)
        wrench = np.repeat(constant, _N_CONSTANT, axis=1), np.repeat(shapes, N_OF_WRENCH - _N_CONSTANT, axis=1)
        sds = np.hstack([gain, known, np.repeat(drift, N_OF_DRIFT - 1, axis=1), known[:, :1], *wrench])
        return sds * np.where(self.attachments, ends, 1.0)


def blocks_of(record: Record, mean: Array, unknowns: Array | None = None) -> Blocks:
    """The blocks of a recording.

    Args:
        record: with ticks of 10 ms.
        mean: (p,) belief about which the motion is linearised.
        unknowns: (n - c,) the columns behind the tensions there; None for 0.
    """
    away = (mean - record.prior.mean) / record.prior.sd
    mean = record.prior.mean + np.clip(away, -FARTHEST, FARTHEST) * record.prior.sd  # where a filter may be lost
    settings = _settings(record)
    if unknowns is None:
        unknowns = np.zeros(1 + len(settings["nuisances"]["mass"]) + N_OF_DRIFT)
    return _blocks_at(record, settings, mean, unknowns)


def _blocks_at(record: Record, settings: Any, mean: Array, unknowns: Array) -> Blocks:
    """The blocks about given values of the columns behind the tensions."""
    nuisances, jaw, states = settings["nuisances"], record.jaw, len(record.start_mean)
    muscles, lines_of_jaw = len(record.parameter_names) // 2, len(jaw["l_o"])
    sizes = len(nuisances["mass"]), len(settings["disturbance_variance"])
    belief: Any = record_zeros(1, belief_dtype(muscles, states, lines_of_jaw, *sizes))[0]
    scratch: Any = record_zeros(1, filter_scratch_dtype(muscles, lines_of_jaw, states, *sizes))[0]
    rows: Any = record_zeros(len(record.time), ROW)
    rows["measured"], rows["samples"][1:], belief["began"] = record.measured, record.samples, record.start_mean
    order, steps = _order(muscles * N_NODES, nuisances), np.zeros(len(belief["score"]))
    of_motion = np.delete(unknowns[1:], slice(-N_OF_WRENCH - N_OF_DRIFT, -N_OF_WRENCH))
    c, lines = muscles * N_NODES, nuisances["line"] >= 0
    of_nuisances = slice(c + 1, c + 1 + sizes[0])
    steps[order[-sizes[0] :]] = of_motion
    most = np.where(lines, _MOST_ATTACHMENTS, _LINEAR)
    steps[of_nuisances] = np.clip(steps[of_nuisances], -most, most)
    jaw = _with_attachments(jaw, nuisances, steps[of_nuisances])
    if sizes[1]:  # beside a disturbance with memory these stay where they are (``learn.recentre``)
        steps[muscles * N_NODES + 1 :][: sizes[0]][nuisances["at_rest"] == 0] = 0.0
    every = max(1, round(BLOCK_S / record.dt), -(-len(record.samples) // MOST_BLOCKS))
    columns = len(steps)
    count = len(record.samples) // every
    kept = np.zeros((count, columns, columns)), np.zeros((count, columns)), np.zeros((count, 5))
    _pass_through(jaw, belief, rows, settings, scratch, (mean.copy(), steps), every, kept)
    information = np.triu(kept[0]) + np.swapaxes(np.triu(kept[0], 1), 1, 2)
    information = np.diff(information[:, order][:, :, order], axis=0, prepend=0.0)
    score = np.diff(kept[1][:, order], axis=0, prepend=0.0) + information @ steps[order]
    read = np.ma.masked_invalid(record.samples[: count * every, 0, [*WRENCH_UNITS]]).reshape(count, every, _N_CONSTANT)
    forces = read.mean(axis=1).filled(np.nan) / [*WRENCH_UNITS.values()]  # of what was read: a gap is no rate
    late = LATE_S * np.nan_to_num(np.gradient(forces, every * record.dt, axis=0)) if count > 1 else 0.0 * forces
    information, score = _drifting(information, score, late)
    by_end = np.zeros((2, len(steps) - c, lines_of_jaw, 3))
    for moved, name in zip(by_end, ("origin", "insertion"), strict=True):
        moved[1 : 1 + sizes[0]] = nuisances[name].reshape(sizes[0], -1, 3)
    by_end = np.insert(by_end[:, order[c:] - c], [len(order) - c - N_OF_WRENCH] * N_OF_DRIFT, 0.0, axis=1)
    tilting = np.append(False, np.abs(nuisances["gravity"]).max(axis=1) > 0.0)
    masks = np.array([_own(nuisances), np.append(False, lines), tilting])[:, order[c:] - c]
    own, ends, tilt = np.insert(masks, [masks.shape[1] - N_OF_WRENCH] * N_OF_DRIFT, False, axis=1)
    return Blocks(
        information=information,
        score=score,
        poses=kept[2],
        own=own,
        attachments=ends,
        tilt=tilt,
        by_end=by_end,
        gain_sd=float(np.sqrt(settings["gain_variance"])),
        scan_assumed=not record.knowledge.exact,
        wrench_assumed=record.knowledge.wrench_N,
        point=belief["point"].copy(),
        basis=belief["basis"].copy(),
        nominal=belief["nominal"].copy(),
        prior_mean=record.prior.mean,
        prior_sd=record.prior.sd,
    )


def _with_attachments(jaw: Any, nuisances: Any, steps: Array) -> Any:
    """A copy of the jaw whose lines are as long as ends moved by ``steps`` make them; derivatives are taken there."""
    lines, shape = nuisances["line"] >= 0, (len(steps), len(jaw["l_o"]), 3)
    by_end = nuisances["origin"].reshape(shape) - nuisances["insertion"].reshape(shape)
    along = jaw["origin"] - jaw["insertion"] + np.tensordot(steps * lines, by_end, 1)
    length = np.linalg.norm(along, axis=1)
    longer = np.einsum("lk,jlk->jl", along / length[:, None], by_end)
    nuisances["l_o"][lines] = longer[lines]
    changed = jaw.copy()
    changed["l_o"] = length - (steps * lines) @ longer
    return changed


def _drifting(information: Array, score: Array, late: Array) -> tuple[Array, Array]:
    """The same with columns of a zero that drifts over each stretch and stays so, and of ``late`` (B, 5) forces."""
    count, columns = score.shape
    constant = np.arange(columns - N_OF_WRENCH, columns - N_OF_WRENCH + _N_CONSTANT)
    share = np.clip(_STRETCHES * (np.arange(count)[:, None] + 0.5) / count - np.arange(_STRETCHES), 0.0, 1.0)
    full = np.zeros((count, columns, columns + N_OF_DRIFT))  # columns of the old ones by the new
    kept = np.delete(np.arange(columns + N_OF_DRIFT), np.arange(constant[0], constant[0] + N_OF_DRIFT))
    full[:, np.arange(columns), kept] = 1.0
    for stretch in range(_STRETCHES):
        full[:, constant, constant + stretch * _N_CONSTANT] = share[:, stretch, None]
    full[:, constant, constant[0] + N_OF_DRIFT - 1] = late
    turned = np.swapaxes(full, 1, 2)
    return turned @ information @ full, np.einsum("bnc,bc->bn", turned, score)


def _settings(record: Record) -> Any:
    """The filter's settings with a wrench of 1 N, and a scan's unknowns where it was told of none."""
    told = not record.knowledge.exact
    knowledge = replace(record.knowledge if told else IMAGED, wrench_N=1.0)
    settings = settings_of_record(replace(record, knowledge=knowledge))
    if not told:  # what readings count for is as the filter had it
        own = settings_of_record(record)
        settings["systematic_error"], settings["full_weight_ticks"] = own["systematic_error"], own["full_weight_ticks"]
    return settings


def _own(nuisances: Any) -> NDArray[np.bool_]:
    """Mask (1 + nuisances,) of the patient's own columns; the gain, the first, is the device's."""
    parts = [np.abs(nuisances[name]).reshape(len(nuisances["mass"]), -1).max(axis=1) for name in _OF_A_SESSION]
    return np.append(False, np.max(parts, axis=0) == 0.0)


def _order(tensions: int, nuisances: Any) -> NDArray[np.intp]:
    """Columns as ``Blocks`` has them: the wrench's, the last that the cell reads and of no motor, behind all others."""
    rest = np.flatnonzero(nuisances["in_cell"] & (nuisances["of_motors"] == 0))
    wrench = rest[-N_OF_WRENCH:]
    others = np.delete(np.arange(len(nuisances["mass"])), wrench)
    return np.concatenate([np.arange(tensions + 1), tensions + 1 + others, tensions + 1 + wrench])


@njit
def _pass_through(
    jaw: Jaw, belief: Belief, rows, settings: FilterSettings, scratch: FilterScratch, point, every, kept
) -> None:
    """Filter ``rows`` about a fixed ``point``: natural logs, and all columns as steps from 0.

    After ``every`` ticks information, score and pose go to the arrays ``kept``, the former as sums from the first
    reading on.
    """
    mean, steps = point
    information, score, poses = kept
    first = belief.nominal.shape[0] * belief.nominal.shape[1] + 1
    begin_filter(jaw, belief, belief.began, settings)
    belief.mean[:] = mean
    belief.point[:] = mean
    belief.cov[:, :] = 0.0
    for i in range(mean.shape[0]):
        belief.cov[i, i] = _WIDTH * _WIDTH
    refocus(belief, scratch.belief)
    for j in range(belief.nuisances.shape[0]):
        belief.nuisances[j] = steps[first + j]
    move_jaw(belief.jaw, settings.nuisances, steps, first)
    begin_motion(belief, belief.began, settings.start_sd)
    forget_readings(belief)
    for k in range(rows.shape[0]):
        measured, samples = read_row(rows[k], scratch)
        take_readings(jaw, belief, measured, samples, k, settings, scratch)
        if k > 0 and k % every == 0 and k // every <= information.shape[0]:
            block = k // every - 1
            information[block] = belief.information
            score[block] = belief.score
            for i in range(5):
                poses[block, i] = belief.motion[i]
