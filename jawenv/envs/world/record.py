"""Everything that one simulated world carries from step to step, as one record; an environment is an array of them."""

from __future__ import annotations

from functools import cache
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from jawenv.device.comfort import N_LIMITS, ComfortRecord, Limits, limits_dtype
from jawenv.device.device import N_ERRORS, N_MOTORS
from jawenv.device.guard import Tracker
from jawenv.device.motors import Motors
from jawenv.filter.belief.state import (
    N_OFFSETS,
    Belief,
    FilterSettings,
    belief_dtype,
    filter_settings_dtype,
    joint_size,
)
from jawenv.filter.model.encoders import N_MEASUREMENTS
from jawenv.filter.model.motion_step import N_NOISE, N_SAMPLES
from jawenv.filter.tick import FilterScratch
from jawenv.kernels.records import Array, record_dtype
from jawenv.mechanics.dynamics import N_STATES
from jawenv.mechanics.jaw import Jaw, jaw_dtype
from jawenv.reality import reality_state_dtype
from jawenv.reality.options import RealityRecord
from jawenv.reality.state import RealityState

N_NORMALS = 36  # 6 unmodelled wrench, 18 load cell, 12 encoders


class Truth:
    """State that only the simulation knows: the patient, the motion, what sensors add, and judgements by these."""

    jaw: Jaw
    log_parameters: Annotated[Array, "parameters"]
    muscles: Annotated[Array, "lines", 2]
    cell_gain: float
    nuisances: Annotated[Array, "nuisances"]  # drawn, in prior sds, as ``belief.nuisances`` has them
    cell_offset: Annotated[Array, N_OFFSETS]  # by shapes of the pose
    turn: Annotated[Array, 3]  # of the mouthpiece about body axes: what the encoders show is turned by it
    cell_turn: Annotated[Array, 3]  # what the load cell shows is turned by this
    no_cell: bool  # whether the force is read without a load cell (``device.force_sensor``)
    motor_errors: Annotated[Array, N_MOTORS, N_ERRORS]  # of that
    slack_below: float  # force of a motor, N
    friction_share: Annotated[Array, N_MOTORS]  # of Coulomb's friction that acts
    motor_rate: Annotated[Array, N_MOTORS]  # at the end of the last tick, m/s
    state: Annotated[Array, N_STATES]
    lift: Annotated[Array, 2]  # of the condyles' midpoint above its path (m), and its rate (m/s)
    unmodelled: Annotated[Array, 6]  # the wrench that no model explains, in this tick
    reality: RealityState
    key: Annotated[NDArray[np.uint64], 2]
    acted: float  # what of the governor acted in the last tick (``device.motors``)
    fractions: Annotated[Array, N_LIMITS]  # largest used fraction of each limit during the last step
    costs: Annotated[Array, N_LIMITS]  # mean cost of each limit during the last step
    governor: float  # share of the last step's ticks in which the governor acted
    violated: bool
    bound: Annotated[Array, "bound", "bound"]
    log_det_bound: float
    log_score_prior: float
    log_score: float
    nees: float


@cache
def truth_dtype(n_muscles: int, n_lines: int, n_nuisances: int, n_bound: int) -> np.dtype[np.void]:
    """Dtype of ``Truth``."""
    return record_dtype(
        Truth,
        jaw=jaw_dtype(n_lines),
        parameters=2 * n_muscles,
        lines=n_lines,
        nuisances=n_nuisances,
        reality=reality_state_dtype(n_lines),
        bound=n_bound,
    )


class Known:
    """State that the device knows: its clock and motors, the clinician's limits, its readings and its belief."""

    tick: int
    limits: Limits
    motors: Motors
    tracker: Tracker  # of targets control
    reading: Annotated[Array, 6]  # load cell, body axes
    belief: Belief
    kept: Belief  # as the last replay of the filter left it
    left_out: float  # share of the last step's readings that were not used
    gated: float  # share of the last step's ticks whose innovation the gate rejected
    log_det_prior: float
    log_det: float


@cache
def known_dtype(n_muscles: int, n_lines: int, n_states: int, n_nuisances: int, n_disturbance: int) -> np.dtype[np.void]:
    """Dtype of ``Known``."""
    return record_dtype(
        Known,
        limits=limits_dtype(n_lines),
        belief=belief_dtype(n_muscles, n_states, n_lines, n_nuisances, n_disturbance),
        kept=belief_dtype(n_muscles, n_states, n_lines, 0, 0 if n_nuisances else n_disturbance),
    )


class World:
    """One world."""

    truth: Truth
    known: Known


@cache
def world_dtype(n_muscles: int, n_lines: int, n_states: int, n_nuisances: int, n_disturbance: int) -> np.dtype[np.void]:
    """Dtype of one world. Filter, observation and the law of targets control are given ``known`` alone.

    Args:
        n_muscles: Those with a stiffness of their own.
        n_lines: Lines along which they pull.
        n_states: Of the motion, in the filter's model.
        n_nuisances: What the filter knows within an sd beside the muscles (``filter.nuisances.changes``).
        n_disturbance: Components of the unmodelled wrench that are states of the filter: 6 where it has memory, or 0.
    """
    truth = truth_dtype(n_muscles, n_lines, n_nuisances, joint_size(n_muscles, n_states, n_nuisances, n_disturbance))
    known = known_dtype(n_muscles, n_lines, n_states, n_nuisances, n_disturbance)
    return record_dtype(World, truth=truth, known=known)


class Control:
    """Settings of the device's control, for all worlds of an environment."""

    servo: bool  # whether servos hold the motors
    targets: bool  # whether the action is the channels' targets
    steps: int  # in an episode
    ticks_per_step: int
    budget: float  # of an episode's discomfort, s; 0 for none


class Settings:
    """Settings that all worlds of an environment share."""

    filter: FilterSettings
    control: Control
    comfort: ComfortRecord
    noise_variance: Annotated[Array, N_NOISE]  # of the wrench not known, as the bound's recursion has it
    reality: RealityRecord
    unmodelled_decay: float  # of the true unmodelled wrench over a tick
    channels: int  # readings in a tick


@cache
def settings_dtype(
    n_muscles: int, n_lines: int, n_states: int, n_nuisances: int = 0, n_disturbance: int = 0
) -> np.dtype[np.void]:
    """Dtype of ``Settings``."""
    return record_dtype(
        Settings, filter=filter_settings_dtype(n_muscles, n_states, n_lines, n_nuisances, n_disturbance)
    )


class Seeing:
    """Working memory of ``observe_world``."""

    muscles: Annotated[Array, "lines", 2]
    tension_limits: Annotated[Array, "lines"]
    fractions: Annotated[Array, N_LIMITS]


@cache
def seeing_dtype(n_lines: int) -> np.dtype[np.void]:
    """Dtype of ``Seeing``."""
    return record_dtype(Seeing, lines=n_lines)


class Scratch:
    """One thread's working memory."""

    rows: Annotated[Array, N_MEASUREMENTS, N_STATES]  # of ``measure``
    filter: FilterScratch
    seeing: Seeing
    observation: Annotated[NDArray[np.float32], "observation"]  # for the law of targets control
    action: Annotated[Array, N_MOTORS]  # of the motors
    normals: Annotated[Array, N_NORMALS]
    measured: Annotated[Array, N_MEASUREMENTS]
    effective: Annotated[Array, "lines", 2]  # F_o and b of the truth's lines during the tick
    acted: float  # what of the governor has acted in this tick
    wrench: Annotated[Array, N_SAMPLES, 6]  # the device's, as the load cell averages it (``load_cell``)
    samples: Annotated[Array, N_SAMPLES, 6]  # what the load cell makes of them
    faults: Annotated[Array, 20]
    fractions: Annotated[Array, N_LIMITS]
    matrix: Annotated[Array, "parameters", "parameters"]
    right: Annotated[Array, "parameters"]
