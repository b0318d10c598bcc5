"""The motion predicted by the past alone, along which derivatives by tensions and nuisances are taken.

A regressor that contains anything of this tick's noise is correlated with this tick's innovation, and its score is
biased: a servo or a stop answers within the tick, so the motion that a reading moves contains an answer to what acted
in the tick and is not known (Forssell & Ljung 1999, Automatica 35:1215). What is predicted from earlier readings is an
instrument.

The motion takes the tick under the smoothed reading of the ticks before, and the Jacobian, the lines of action and the
rows of the readings are taken along it. At the first readings the muscles may be far from what is believed, and so is
what they predict: there the lines lie at a pose moved on at constant rates, and the rest along the tick's own motion.
"""

from __future__ import annotations

from functools import cache
from math import isfinite
from typing import Annotated

import numpy as np

from jawenv.filter.belief.state import Belief
from jawenv.filter.model.encoders import N_MEASUREMENTS, measure
from jawenv.filter.model.motion_step import N_SAMPLES, move
from jawenv.filter.updates.disturbance import add_disturbance
from jawenv.kernels.compiled import njit
from jawenv.kernels.records import Array, record_dtype
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import angle_rates

FIRST_READINGS = 160  # a window's end, at which they are filtered again (``tick.replay``)


class Instrument:
    """Prediction from the past alone."""

    motion: Annotated[Array, "states"]  # at the end of the tick
    held: Annotated[Array, N_SAMPLES, N_WRENCH]  # the smoothed reading as samples of this tick


@cache
def instrument_dtype(n_states: int) -> np.dtype[np.void]:
    """Dtype of ``Instrument``."""
    return record_dtype(Instrument, states=n_states)


@njit
def all_finite(values):
    """Whether all of ``values`` (n) are numbers."""
    total = 0.0
    for i in range(values.shape[0]):
        total += values[i]
    return isfinite(total)


@njit
def is_early(belief: Belief):
    """Whether so little was read that a prediction may be far off, as the muscles may be that it is made by.

    Never where more than the muscles is unknown, or the disturbance has memory: nuisances are told apart from muscles
    by small differences of columns, which the tick's own noise hides from the first reading on.
    """
    alone = belief.nuisances.shape[0] == 0 and belief.motion.shape[0] == belief.predicted.shape[0]
    return alone and belief.readings < FIRST_READINGS


@njit
def _coast(start, dt, after):
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
def predict_from_past(jaw: Jaw, belief: Belief, dt, scratch):
    """Into ``scratch.instrument`` the motion at the end of the tick under the smoothed reading, finite or not.

    Its derivative is left in ``scratch.step``. Early the pose alone, at constant rates.
    """
    instrument = scratch.instrument
    for i in range(instrument.motion.shape[0]):
        instrument.motion[i] = scratch.start_motion[i]
    if is_early(belief):
        _coast(scratch.start_motion, dt, instrument.motion)
        return
    for i in range(N_SAMPLES):
        for k in range(N_WRENCH):
            instrument.held[i, k] = belief.smoothed[k]
    add_disturbance(belief, instrument.motion.shape[0], instrument.held, instrument.held)
    move(jaw, instrument.motion, instrument.held, dt, True, scratch.step)
    belief.predicted[:] = instrument.motion


@njit
def set_rows_of_past(jaw: Jaw, belief: Belief, used, scratch):
    """The rows of the used readings at the predicted motion."""
    measure(jaw, belief.predicted, scratch.rows, scratch.expected)
    for i in range(N_MEASUREMENTS):
        if not used[i]:
            scratch.rows[i, :] = 0.0
