"""State and settings of the online filter, and its initialisation.

Three parts make the bias-separated form of the Kalman filter (Friedland 1969, IEEE Trans. Autom. Control 14:359):

* ``motion`` (q, u) and its covariance ``motion_cov``, given muscles at ``mean``;
* ``by_tension``, the derivative of that motion by the coefficients c of ``basis`` and by the load cell's gain error;
* ``information`` and ``score``, matrix and gradient at ``nominal`` of the quadratic log-likelihood of c and the gain
  error, accumulated from the innovations. Between two updates of the belief the matrix's upper half alone is kept.

Forces are linear in c, so the information of early data, linearised at a poor estimate, is as valid as that of late
data, and the constant parameters need no process noise. The belief about the natural-log parameters, ``mean`` and
``cov``, follows from information, score and prior (``posterior``).
"""

from __future__ import annotations

from functools import cache
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from jawenv.device.device import N_ERRORS, N_MOTORS, Linkage
from jawenv.filter.model.basis import N_NODES, Basis, basis_dtype, set_coefficients
from jawenv.filter.model.encoders import N_MEASUREMENTS
from jawenv.filter.model.motion_step import padded
from jawenv.kernels.compiled import njit
from jawenv.kernels.records import Array, copy_record, record_dtype
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.mechanics.jaw import Jaw

KEPT = 7  # beliefs, each after twice as many readings as the one before
N_CELLS = 1024  # of poses, see ``readings.model_error``
FARTHEST = 4.0  # sds that a nuisance may be from its nominal value, drawn or believed
N_SHAPES = 6  # of the pose, by which a load cell's offset goes with it
N_OFFSETS = N_SHAPES * N_WRENCH


def tension_columns(n_muscles: int, n_nuisances: int = 0) -> int:
    """Columns of ``by_tension``: the coefficients, the shared ones, and zeros at the end."""
    return padded(n_muscles * N_NODES + shared_columns(n_nuisances))


def shared_columns(n_nuisances: int) -> int:
    """Columns of no muscle: gain error and nuisances; without these what the gain error makes of inertia, by itself."""
    return 1 + n_nuisances if n_nuisances else 2


def joint_size(n_muscles: int, n_states: int, n_nuisances: int = 0, n_disturbance: int = 0) -> int:
    """States of a joint recursion: the motion, each muscle's two, the gain error, and what is integrated out."""
    return n_states + 2 * n_muscles + 1 + n_nuisances + n_disturbance


class Block:
    """Sums of a block of ticks, see ``misfit``."""

    ticks: int
    innovation: Annotated[Array, N_MEASUREMENTS]  # whitened
    rows: Annotated[Array, N_MEASUREMENTS, "columns"]  # whitened rows by tension
    speed: float  # of the mouthpiece, over what is slow
    largest: float  # misfit of the blocks so far
    slow: int  # blocks in which the jaw was slow so far
    total: float  # their statistics


class Drift:
    """The kept beliefs, see ``drift``."""

    kept: int
    judged: int  # readings at the last judgement
    means: Annotated[Array, KEPT, "parameters"]
    factors: Annotated[Array, KEPT, "parameters", "parameters"]  # of the covariances, as ``decompose`` leaves them


class _Dwell:
    """The poses at which the jaw has been, see ``readings.model_error``."""

    visits: Annotated[Array, N_CELLS]  # ticks spent at poses alike
    visited: float  # of the pose, smoothed as drift rates are
    drift_rates: Annotated[Array, 6]  # velocities (u), smoothed


class Sensors:
    """The sensors' last readings, see ``readings.screening``."""

    last_measured: Annotated[Array, N_MEASUREMENTS]
    encoder_step: Annotated[Array, N_MEASUREMENTS]  # infinite before a change
    repeats: Annotated[Array, N_MEASUREMENTS]  # how often in a row each encoder has shown the same; infinite if frozen
    cell_step: Annotated[Array, N_WRENCH]
    unchanged_at: Annotated[Array, 6]  # pose (q) when the load cell last changed
    held_sample: Annotated[Array, N_WRENCH]
    lost_for: Annotated[Array, N_WRENCH]  # s since the load cell's component was used


class Belief:
    """The filter's state."""

    motion: Annotated[Array, "motion"]  # and after it the disturbance, where it has memory
    motion_cov: Annotated[Array, "motion", "motion"]
    began: Annotated[Array, "states"]  # motion before the first reading
    by_tension: Annotated[Array, "motion", "columns"]
    information: Annotated[Array, "columns", "columns"]
    score: Annotated[Array, "columns"]
    basis: Basis
    block: Block
    drift: Drift
    misfit: float  # the alarm: the largest so far of what ``misfit`` and ``drift`` find
    steps: Annotated[Array, "columns"]  # coefficients, gain error and nuisances of the mean less those of the point
    point: Annotated[Array, "parameters"]  # natural logs about which motion and readings are linearised
    nominal: Annotated[Array, "muscles", N_NODES]  # c at ``point``
    nuisances: Annotated[Array, "nuisances"]  # at the point, in prior sds
    nuisances_replayed_at: Annotated[Array, "nuisances"]
    friction_share: Annotated[Array, "motors"]  # see ``device.force_sensor``
    jaw: Jaw  # the filter's model at the point, where there are nuisances
    predicted: Annotated[Array, "states"]  # motion at the tick's end as the past alone has it
    smoothed: Annotated[Array, N_WRENCH]  # the load cell's trend over a shorter time, corrected
    # L^-1 of ``decompose``, of the information about gain error and nuisances at given tensions
    nuisance_factor: Annotated[Array, "shared", "shared"]
    mean: Annotated[Array, "parameters"]  # natural logs
    cov: Annotated[Array, "parameters", "parameters"]
    replayed_at: Annotated[Array, "parameters"]  # mean at which the readings were last filtered again
    trend: Annotated[Array, N_WRENCH]  # of the load cell
    readings: int  # ticks at the end of which an encoder was used, and that something could be learnt from
    refused: int  # ticks on end, up to the last one, whose readings were refused
    settling_ticks: int  # ticks of which nothing is learnt from here on, see ``readings.screening``
    contact_ticks: int  # the same, after teeth
    dwell: _Dwell
    replayed: int  # the tick up to which readings were last filtered again; 0 for none
    sensors: Sensors


@cache
def belief_dtype(
    n_muscles: int, n_states: int, n_lines: int = 1, n_nuisances: int = 0, n_disturbance: int = 0
) -> np.dtype[np.void]:
    """Dtype of ``Belief``."""
    return record_dtype(
        Belief,
        motion=n_states + n_disturbance,
        columns=tension_columns(n_muscles, n_nuisances),
        muscles=n_muscles,
        parameters=2 * n_muscles,
        nuisances=n_nuisances,
        shared=shared_columns(n_nuisances),
        motors=N_MOTORS if n_nuisances else 0,
        states=n_states,
        lines=n_lines if n_nuisances else 1,
    )


class Nuisances:
    """The changes that one sd of each nuisance makes."""

    mass: Annotated[Array, "nuisances"]
    # Mass times centre of mass: the equations of motion are linear in these.
    first_moment: Annotated[Array, "nuisances", 3]
    inertia: Annotated[Array, "nuisances", 9]  # about the contact point
    gravity: Annotated[Array, "nuisances", 3]  # head axes
    tone: Annotated[Array, "nuisances"]
    fossa_drop: Annotated[Array, "nuisances"]
    fossa_frequency: Annotated[Array, "nuisances"]
    damping_rotation: Annotated[Array, "nuisances"]
    damping_sliding: Annotated[Array, "nuisances"]
    mouthpiece: Annotated[Array, "nuisances", 3]
    zero: Annotated[Array, "nuisances", 3]
    origin: Annotated[Array, "nuisances", "attachments"]
    insertion: Annotated[Array, "nuisances", "attachments"]
    l_o: Annotated[Array, "nuisances", "lines"]
    offset: Annotated[Array, "nuisances", N_OFFSETS]  # of the load cell's reading, by shapes of the pose
    turn: Annotated[Array, "nuisances", 3]  # of the mouthpiece about body axes, rad
    cell_turn: Annotated[Array, "nuisances", 3]  # of the load cell, with the mouthpiece and by itself
    line: Annotated[NDArray[np.int64], "nuisances"]  # whose ends it moves and nothing else, or -1
    # Whether it is one of the body's numbers once more, as accelerations show it beside a disturbance with memory; and
    # whether a jaw at rest shows it, which neither these nor damping do.
    again: Annotated[NDArray[np.uint8], "nuisances"]
    at_rest: Annotated[NDArray[np.uint8], "nuisances"]
    moves: Annotated[NDArray[np.uint8], "nuisances"]  # whether it is in the equations of motion elsewhere
    in_cell: Annotated[NDArray[np.uint8], "nuisances"]  # whether the load cell reads it
    turns: Annotated[NDArray[np.uint8], "nuisances"]  # whether it turns what the encoders read
    reads: Annotated[NDArray[np.uint8], "nuisances"]  # whether the encoders read it at the same motion
    # Whether it is one of a force that no load cell reads, and of nothing else.
    of_motors: Annotated[NDArray[np.uint8], "nuisances"]
    motor_errors: Annotated[Array, "nuisances", N_MOTORS, N_ERRORS]  # see ``device.force_sensor``
    linkage: Linkage


@cache
def nuisance_dtype(n_lines: int, n: int) -> np.dtype[np.void]:
    """Dtype of ``Nuisances``."""
    return record_dtype(Nuisances, nuisances=n, attachments=3 * n_lines, lines=n_lines)


class FilterSettings:
    """The filter's settings: device, prior and noise."""

    dt: float
    used: Annotated[NDArray[np.uint8], N_MEASUREMENTS]
    measurement_variance: Annotated[Array, N_MEASUREMENTS]
    wrench_variance: Annotated[Array, N_WRENCH]  # of the wrench not known
    model_error: float  # share of the force that the model may have wrong at a pose, as noise of the motion
    systematic_error: float  # the same, by which what is read again counts for less
    full_weight_ticks: float  # ticks at a pose that count in full all the same
    gain_variance: float
    cell_repeats: Annotated[NDArray[np.uint8], N_WRENCH]  # whether a component of the load cell has no noise
    rough: Annotated[Array, 3]  # see ``screening.rough_change``
    motion_only: bool  # whether the motion is filtered at the prior's mean, and nothing is learnt
    start_sd: Annotated[Array, "motion"]  # of motion and disturbance before the first reading
    disturbance_decay: float  # over a tick, of a disturbance with memory
    disturbance_variance: Annotated[Array, "disturbance"]  # of its innovation in a tick
    basis: Basis
    prior_mean: Annotated[Array, "parameters"]
    prior_sd: Annotated[Array, "parameters"]
    nuisances: Nuisances


@cache
def filter_settings_dtype(
    n_muscles: int, n_states: int, n_lines: int = 1, n_nuisances: int = 0, n_disturbance: int = 0
) -> np.dtype[np.void]:
    """Dtype of ``FilterSettings``."""
    return record_dtype(
        FilterSettings,
        motion=n_states + n_disturbance,
        disturbance=n_disturbance,
        basis=basis_dtype(n_muscles),
        parameters=2 * n_muscles,
        nuisances=nuisance_dtype(n_lines, n_nuisances),
    )


@njit
def begin_motion(belief: Belief, motion, sd):
    """Set the mean of the motion (n) before the first reading, no disturbance, and the sds of both."""
    belief.motion[:] = 0.0
    for i in range(belief.began.shape[0]):
        belief.began[i] = motion[i]
        belief.motion[i] = motion[i]
        belief.predicted[i] = motion[i]
    lose_motion(belief, sd)


@njit
def lose_motion(belief: Belief, sd):
    """Reset the motion's covariance to ``sd`` (n), uncorrelated with the tensions; the mean stays."""
    belief.motion_cov[:, :] = 0.0
    for i in range(sd.shape[0]):
        belief.motion_cov[i, i] = sd[i] * sd[i]
    belief.by_tension[:, :] = 0.0


@njit
def begin_belief(basis: Basis, belief: Belief, log_parameters, prior_sd):
    """Initialise the parameters: mean ``log_parameters`` (p), the prior's sds.

    ``log_parameters`` are the prior's mean, or another linearisation point. The caller sets the motion.
    """
    belief.cov[:, :] = 0.0
    for i in range(log_parameters.shape[0]):
        belief.mean[i] = log_parameters[i]
        belief.point[i] = log_parameters[i]
        belief.replayed_at[i] = log_parameters[i]
        belief.cov[i, i] = prior_sd[i] * prior_sd[i]
    copy_record(belief.basis, basis)
    belief.nuisances[:] = 0.0
    belief.nuisances_replayed_at[:] = 0.0
    belief.nuisance_factor[:, :] = 0.0
    for i in range(belief.nuisance_factor.shape[0]):
        belief.nuisance_factor[i, i] = 1.0
    forget_readings(belief)


@njit
def begin_block(block: Block):
    """Sums of no tick."""
    block.ticks, block.speed = 0, 0.0
    block.innovation[:] = 0.0
    block.rows[:, :] = 0.0


@njit
def _begin_sensors(sensors: Sensors):
    """Nothing is read."""
    sensors.last_measured[:] = np.nan
    sensors.encoder_step[:] = np.inf
    sensors.repeats[:] = 0.0
    sensors.cell_step[:] = np.inf
    sensors.unchanged_at[:] = 0.0
    sensors.held_sample[:] = 0.0
    sensors.lost_for[:] = 0.0


@njit
def forget_readings(belief: Belief):
    """Discard all information, sensor history and kept beliefs; motion and belief stay."""
    belief.by_tension[:, :] = 0.0
    belief.information[:, :] = 0.0
    belief.score[:] = 0.0
    belief.steps[:] = 0.0
    belief.trend[:] = 0.0
    belief.smoothed[:] = 0.0
    belief.friction_share[:] = 0.0
    belief.drift.kept, belief.drift.judged = 0, 0
    begin_block(belief.block)
    belief.block.largest, belief.block.slow, belief.block.total, belief.misfit = 0.0, 0, 0.0, 0.0
    belief.settling_ticks, belief.contact_ticks, belief.readings, belief.refused = 0, 0, 0, 0
    belief.dwell.drift_rates[:] = 0.0
    belief.dwell.visits[:], belief.dwell.visited = 0.0, 0.0
    _begin_sensors(belief.sensors)
    set_coefficients(belief.basis, belief.point, belief.nominal)
