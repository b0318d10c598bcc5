"""The motion predicted by the past alone, along which derivatives by tensions and nuisances are taken.

A regressor that contains anything of this tick's noise is correlated with this tick's innovation, and its score is
biased: a servo or a stop answers within the tick, so the motion that a reading moves contains an answer to what acted
in the tick and is not known (Forssell & Ljung 1999, Automatica 35:1215). What is predicted from earlier readings is an
instrument.

Where the muscles alone are unknown, a pose predicted at constant rates suffices. Nuisances and a disturbance with
memory are told apart from them by small differences between columns that are nearly parallel, and there the Jacobian,
the rates and the rows of the readings must be predicted as well: the motion takes the tick under the smoothed reading
of the ticks before, and all is linearised along it.
"""

from __future__ import annotations

from functools import cache
from math import isfinite
from typing import Annotated

import numpy as np

from jawenv.filter.belief.state import Belief
from jawenv.filter.model.encoders import N_MEASUREMENTS, expect
from jawenv.filter.model.joint_step import N_SAMPLES
from jawenv.filter.model.motion_step import move
from jawenv.filter.updates.disturbance import add_disturbance
from jawenv.kernels.compiled import njit, where
from jawenv.kernels.records import Array, record_dtype
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import angle_rates


class Instrument:
    """What the past alone predicts."""

    motion: Annotated[Array, "states"]  # at the end of the tick
    total: Annotated[Array, "states", "wide"]  # its derivative by state and wrench, [A, G]
    held: Annotated[Array, N_SAMPLES, N_WRENCH]  # the smoothed reading as samples of this tick


@cache
def instrument_dtype(n_states: int) -> np.dtype[np.void]:
    """Dtype of ``Instrument``."""
    return record_dtype(Instrument, states=n_states, wide=n_states + N_WRENCH)


@njit
def all_finite(values):
    """Whether all of ``values`` (n) are numbers."""
    total = 0.0
    for i in range(values.shape[0]):
        total += values[i]
    return isfinite(total)


@njit
def coast(start, dt, after):
    """The pose after ``dt`` at the rates of ``start``, into the first half of ``after``."""
    half = after.shape[0] // 2
    first = half - 3  # of the angles
    pose = (0.0, 0.0, start[first], start[first + 1], start[first + 2])
    turning = angle_rates(pose, (start[half + first], start[half + first + 1], start[half + first + 2]))
    for i in range(first):
        after[i] = start[i] + dt * start[half + i]
    for i in range(3):
        after[first + i] = start[first + i] + dt * turning[i]


@njit
def hold_reading(jaw: Jaw, belief: Belief, dt, scratch):
    """The motion at the end of the tick under the smoothed reading, finite or not, and its derivative."""
    instrument = scratch.instrument
    for i in range(N_SAMPLES):
        for k in range(N_WRENCH):
            instrument.held[i, k] = belief.smoothed[k]
    add_disturbance(belief, instrument.motion.shape[0], instrument.held, instrument.held)
    for i in range(instrument.motion.shape[0]):
        instrument.motion[i] = scratch.start_motion[i]
    move(jaw, instrument.motion, instrument.held, dt, scratch.step)
    instrument.total[:, :] = scratch.step.total
    belief.predicted[:] = instrument.motion


def _has_nuisances(belief):
    return belief.typeof("predicted").shape[0]


def _coast(jaw: Jaw, belief: Belief, dt, scratch):
    coast(scratch.start_motion, dt, scratch.instrument.motion)


@where(_has_nuisances, otherwise=_coast)
def predict_from_past(jaw: Jaw, belief: Belief, dt, scratch):
    """Into ``scratch.instrument`` what the past alone predicts of the tick: of the motion, or of the pose alone."""
    hold_reading(jaw, belief, dt, scratch)


def _along_the_motion(belief: Belief, scratch):
    return scratch.step.total


@where(_has_nuisances, otherwise=_along_the_motion)
def jacobian_of_tick(belief: Belief, scratch):
    """[A, G] of the tick, along the predicted motion where more than the muscles is unknown."""
    return scratch.instrument.total


@where(_has_nuisances)
def set_rows_of_past(jaw: Jaw, belief: Belief, used, scratch):
    """Where more than the muscles is unknown, the rows of the used readings at the predicted motion."""
    expect(jaw, belief.predicted, scratch.rows, scratch.expected)
    for i in range(N_MEASUREMENTS):
        if not used[i]:
            scratch.rows[i, :] = 0.0
