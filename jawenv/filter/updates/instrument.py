"""The motion predicted by the past alone, along which derivatives by tensions and nuisances are taken.

A regressor that contains anything of this tick's noise is correlated with this tick's innovation, and its score is
biased: a servo or a stop answers within the tick, so the motion that a reading moves contains an answer to what acted
in the tick and is not known (Forssell & Ljung 1999, Automatica 35:1215). What is predicted from earlier readings is an
instrument.

The motion takes the tick under the smoothed reading of the ticks before, and the Jacobian, the lines of action and the
rows of the readings are taken along it.
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
from jawenv.kernels.compiled import njit
from jawenv.kernels.records import Array, record_dtype
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.jaw import Jaw


class Instrument:
    """What the past alone predicts."""

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
def predict_from_past(jaw: Jaw, belief: Belief, dt, scratch):
    """Into ``scratch.instrument`` the motion at the end of the tick under the smoothed reading, finite or not.

    Its derivative is left in ``scratch.step``.
    """
    instrument = scratch.instrument
    for i in range(N_SAMPLES):
        for k in range(N_WRENCH):
            instrument.held[i, k] = belief.smoothed[k]
    add_disturbance(belief, instrument.motion.shape[0], instrument.held, instrument.held)
    for i in range(instrument.motion.shape[0]):
        instrument.motion[i] = scratch.start_motion[i]
    move(jaw, instrument.motion, instrument.held, dt, True, scratch.step)
    belief.predicted[:] = instrument.motion


@njit
def set_rows_of_past(jaw: Jaw, belief: Belief, used, scratch):
    """The rows of the used readings at the predicted motion."""
    expect(jaw, belief.predicted, scratch.rows, scratch.expected)
    for i in range(N_MEASUREMENTS):
        if not used[i]:
            scratch.rows[i, :] = 0.0
