"""The effects' memory from tick to tick, in each world."""

from __future__ import annotations

from functools import cache
from typing import Annotated

import numpy as np

from jawenv.kernels.compiled import njit
from jawenv.kernels.records import Array, record_dtype
from jawenv.kernels.vec3 import add
from jawenv.mechanics.forces import muscle_pull
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import contact_point, rotation
from jawenv.reality.options import RealityRecord

# With the tick that sampling and holding take of themselves, the longest latency is one tick more.
DELAY_TICKS = 7


class RealityState:
    """The effects' state for a jaw with so many muscle lines, SI units."""

    delay: Annotated[Array, DELAY_TICKS, "lines"]  # the reflex's excitation of past ticks, the last one first
    activation: Annotated[Array, "lines"]  # the reflex's tension
    creep: Annotated[Array, "lines"]  # lengthening over creep_share, relative to l_o
    slow_creep: Annotated[Array, "lines"]  # the same over creep_slow_share
    swallow_clock: float  # s since the last swallow began
    rest_length: Annotated[Array, "lines"]
    bias: Annotated[Array, 6]  # of the load cell, body axes
    play: Annotated[Array, 6]  # what the encoders show of the mouthpiece's place and angles
    shown: Annotated[Array, 18]  # the last reading of each encoder and each component of the load cell


@cache
def reality_state_dtype(n_lines: int) -> np.dtype[np.void]:
    """Dtype of ``RealityState``."""
    return record_dtype(RealityState, lines=n_lines)


@njit
def reset_reality(reality: RealityRecord, state: RealityState, jaw: Jaw, muscles, q, lift, measured, normals):
    """Begin an episode at rest: tissue without creep or reflex, play centred, a load-cell bias drawn.

    Args:
        reality: Record of dtype ``REALITY``.
        state: Record of dtype ``reality_state_dtype``; written.
        jaw: The truth's record.
        muscles: (lines, 2) F_o and b of the truth.
        q: The rest pose; its lengths are those above which tissue creeps.
        lift: Of the condyles' midpoint above its path there (m), and its rate, as in ``update_tissue``.
        measured: (6 or more) place and angles of the mouthpiece there, without noise.
        normals: (6 or more) standard normals that belong to the load cell's bias alone.
    """
    contact, body_to_head = add(contact_point(jaw, q), (0.0, 0.0, lift[0])), rotation(q)
    for i in range(muscles.shape[0]):
        _, _, length, _ = muscle_pull(jaw, muscles, i, contact, body_to_head)
        state.rest_length[i] = length
        state.activation[i] = 0.0
        state.creep[i], state.slow_creep[i] = 0.0, 0.0
        for tick in range(state.delay.shape[0]):
            state.delay[tick, i] = 0.0
    state.swallow_clock = 0.5 * reality.swallow_every
    for k in range(6):
        state.bias[k] = (reality.cell_bias_force if k < 3 else reality.cell_bias_moment) * normals[k]
        state.play[k] = measured[k]
    for k in range(18):
        state.shown[k] = np.nan
