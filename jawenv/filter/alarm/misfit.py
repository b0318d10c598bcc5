"""Misfit: whether the readings fit the model at all.

If the model is right, whitened innovations are white, with sd 1. Their sum over a block of n ticks, over sqrt(n), has
the covariance I + M Cov M^T, where M is the same sum of the whitened rows by tension and Cov what is still not known of
the coefficients, the gain error and the nuisances. What the model lacks is rarely white: a constant force, a wrong
lever, a disturbance with memory add up over a block, and noise does not. The statistic is chi-squared with 12 degrees
of freedom; the misfit of the blocks is the second largest of the episode over ``ALARM``, as a single one may be of a
stop, and what the model lacks comes again. A slow movement hardly contradicts a wrong model in any one second, and a
little in each. So the mean of the blocks in which the jaw is slow has a limit of its own; in fast ones the filter's own
steps leave as much. What the belief takes in without a misfit of readings, ``drift`` sees.

Ticks that the load cell's samples do not resolve (``readings.screening``) are left out.

The sum is kept at the belief's point: where that moves, it is corrected by M (``move_block``), and a replay begins it
anew. It is judged at the belief's present mean (``belief.steps`` from the point).
"""

from __future__ import annotations

from math import sqrt

from jawenv.filter.belief.state import Belief, Block, begin_block
from jawenv.filter.model.encoders import N_MEASUREMENTS
from jawenv.filter.readings.model_error import speed_of
from jawenv.filter.updates.measurement_update import UpdateScratch, add_muscles, squared_length
from jawenv.kernels.compiled import njit
from jawenv.kernels.linalg import decompose
from jawenv.mechanics.jaw import Jaw

BLOCK = 100  # ticks: a second, long beside the jaw's own motion and short beside a maneuver
ALARM = 50.0  # chi-squared of 12 has a chance of 1e-6 to be above: linearisation takes its share

SLOW = 0.01  # m/s, on average over a block
FEWEST = 8  # slow blocks, of which each counts for ``MOST`` at most, and whose mean has so many sds above its own
MOST, MARGIN = 25.0, 1.75


@njit
def add_to_block(jaw: Jaw, belief: Belief, scratch: UpdateScratch):
    """Add a tick's whitened innovation and rows; judge the block where it is full."""
    block = belief.block
    for i in range(N_MEASUREMENTS):
        block.innovation[i] += scratch.whitened_innovation[i]
    block.rows += scratch.by_tension_rows
    block.speed += speed_of(jaw, belief.motion) / (SLOW * BLOCK)
    block.ticks += 1
    if block.ticks == BLOCK:
        _judge_block(belief, scratch)
        begin_block(block)


@njit
def move_block(block: Block, steps):
    """The sums at coefficients and nuisances that are larger by ``steps`` (columns)."""
    for i in range(N_MEASUREMENTS):
        for j in range(steps.shape[0]):
            block.innovation[i] -= block.rows[i, j] * steps[j]


@njit
def _judge_block(belief: Belief, scratch: UpdateScratch):
    """Let ``misfit`` be at least the second largest of the blocks, and keep the largest."""
    block, share = belief.block, 1.0 / sqrt(BLOCK)
    move_block(block, belief.steps)
    for i in range(N_MEASUREMENTS):
        scratch.innovation[i] = share * block.innovation[i]
        for j in range(block.rows.shape[1]):
            scratch.by_tension_rows[i, j] = share * block.rows[i, j]
        for j in range(i + 1):
            scratch.factor[i, j] = 1.0 if i == j else 0.0
    add_muscles(belief, scratch)
    if decompose(scratch.factor):
        statistic = squared_length(scratch)
        misfit = statistic / ALARM
        belief.misfit = max(belief.misfit, min(block.largest, misfit))
        block.largest = max(block.largest, misfit)
        if block.speed < 1.0:
            _add_slow(belief, min(statistic, MOST))


@njit
def _add_slow(belief: Belief, statistic):
    """Judge the mean of the slow blocks with one more of them."""
    block = belief.block
    block.slow += 1
    block.total += statistic
    if block.slow >= FEWEST:
        limit = N_MEASUREMENTS + MARGIN * sqrt(2.0 * N_MEASUREMENTS / block.slow)
        belief.misfit = max(belief.misfit, block.total / block.slow / limit)
