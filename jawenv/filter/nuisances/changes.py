"""Nuisances of the filter, known only within an sd: anatomy, mass, the mouthpiece's seat, the load cell.

Each nuisance is a number v with prior N(0, 1). Its *change* is what one sd of it adds to the numbers of the jaw, to
the orientation of the mouthpiece, and to the load cell's reading. The motion's derivative by v is carried beside that
by the tensions (``state``), and v is integrated out of the information (``posterior``), as the cell's gain error is.

The derivative of the motion enters as a wrench at the mouthpiece: the change of the force and moment that the equations
of motion leave over at the same acceleration, S^T (F - m a_c) and tau - (I omega' + omega x I omega + m rho x C a_c + c
omega), carried by the wrench with the same projection. The derivative of the readings at the same motion is added where
they are expected.
"""

from __future__ import annotations

from typing import NamedTuple

from jawenv.filter.belief.state import Belief, FilterSettings, Nuisances
from jawenv.filter.model.encoders import N_MEASUREMENTS, N_POSE, read_motion
from jawenv.filter.model.regressors import at_mouthpiece, left_over, middle_of
from jawenv.filter.nuisances.changed_jaw import change_jaw, copy_jaw, copy_rest, move_jaw
from jawenv.filter.nuisances.if_any import NuisanceScratch
from jawenv.filter.nuisances.turned import add_offset, turn_readings, turn_wrench
from jawenv.filter.nuisances.without_cell import (
    correct_motors,
    has_motors,
    motors_of,
    move_friction,
    set_motor_column,
)
from jawenv.kernels.compiled import njit, where
from jawenv.kernels.vec3 import add, apply, apply_transposed, cross, dot, scale, subtract
from jawenv.mechanics.forces import muscle_pull
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import Five, contact_point, fossa, rotation

STEP = 0.01  # sds of the differences that stand for derivatives
STILL = (0.0, 0.0, 0.0, 0.0, 0.0)


@njit
def _line_change(jaw: Jaw, muscles, nuisances: Nuisances, j, contact, body_to_head):
    """The derivative of force and moment (head axes) of the line whose ends nuisance j moves, by one sd of it.

    T = F_o exp(b (l / l_o - 1)) along e = v / l, with v from the insertion to the origin: dl = e dv, de = (dv - e dl) /
    l. F_o is the tension at l_o, which moves with the ends (``l_o``).
    """
    i = nuisances.line[j]
    arm, direction, length, tension = muscle_pull(jaw, muscles, i, contact, body_to_head)
    moved, origin = nuisances.insertion[j], nuisances.origin[j]
    shift = apply(body_to_head, (moved[3 * i], moved[3 * i + 1], moved[3 * i + 2]))
    change = subtract((origin[3 * i], origin[3 * i + 1], origin[3 * i + 2]), shift)
    longer, l_o = dot(direction, change), jaw.l_o[i]
    stretch = longer / l_o - length * nuisances.l_o[j, i] / (l_o * l_o)
    whole = tension + jaw.tone
    across = scale(whole / length, subtract(change, scale(longer, direction)))
    pull = add(scale(tension * muscles[i, 1] * stretch, direction), across)
    return pull, add(cross(arm, pull), cross(shift, scale(whole, direction)))


@njit
def _body_change(changed: Jaw, muscles, at, base):
    """The derivative of ``left_over``, ``base`` at the arguments ``at``, by what ``changed`` has ``STEP`` sds of."""
    x, y, moment = left_over(changed, muscles, *at)
    return (x - base[0]) / STEP, (y - base[1]) / STEP, scale(1.0 / STEP, subtract(moment, base[2]))


class Midway(NamedTuple):
    """A jaw half way through a tick, as the past alone has it (``instrument``)."""

    pose: Five
    u: Five  # rates
    rate: Five  # their rate of change
    reading: tuple[float, float, float, float, float, float]  # of the load cell, smoothed
    separate_statics: bool  # whether what a jaw at rest shows is separate


@njit
def set_wrenches(jaw: Jaw, muscles, at: Midway, nuisances: Nuisances, first, line_wrench, scratch: NuisanceScratch):
    """Into the columns of ``line_wrench`` (6, columns) from ``first`` on the wrench of one sd of each nuisance."""
    pose, reading = at.pose, at.reading
    body_to_head = rotation(pose)
    contact = contact_point(jaw, pose)
    _, slope, _, _ = fossa(jaw, pose[0])
    copy_rest(jaw, scratch.jaw)
    moving, still = (pose, at.u, reading, at.rate), (pose, STILL, reading, STILL)
    base_moving, base_still = left_over(jaw, muscles, *moving), left_over(jaw, muscles, *still)
    motors = motors_of(nuisances, jaw, (pose, at.u, body_to_head, reading), scratch)
    for j in range(nuisances.mass.shape[0]):
        if nuisances.of_motors[j]:
            set_motor_column(nuisances, j, (body_to_head, motors), first + j, line_wrench)
            continue
        x, y, moment = 0.0, 0.0, (0.0, 0.0, 0.0)
        if nuisances.line[j] >= 0:
            force, moment = _line_change(jaw, muscles, nuisances, j, contact, body_to_head)
            x, y, moment = force[0] + slope * force[2], force[1], apply_transposed(body_to_head, moment)
        elif nuisances.moves[j]:
            change_jaw(jaw, nuisances, j, STEP, scratch.jaw)
            if at.separate_statics and nuisances.at_rest[j]:
                x, y, moment = _body_change(scratch.jaw, muscles, still, base_still)
            else:
                x, y, moment = _body_change(scratch.jaw, muscles, moving, base_moving)
            if at.separate_statics and not nuisances.at_rest[j]:
                x_rest, y_rest, moment_rest = _body_change(scratch.jaw, muscles, still, base_still)
                x, y, moment = x - x_rest, y - y_rest, subtract(moment, moment_rest)
        pull, moment = at_mouthpiece(jaw, pose, x, y, moment)
        # The reading is of axes that are turned, and has an offset.
        turn = (nuisances.cell_turn[j, 0], nuisances.cell_turn[j, 1], nuisances.cell_turn[j, 2])
        pull = add(pull, cross(turn, (reading[0], reading[1], reading[2])))
        moment = add(moment, cross(turn, (reading[3], reading[4], reading[5])))
        for i in range(3):
            line_wrench[i, first + j], line_wrench[3 + i, first + j] = pull[i], moment[i]
        if nuisances.in_cell[j]:
            add_offset(nuisances.offset[j], -1.0, pose, line_wrench[:, first + j])


@njit
def add_readings(jaw: Jaw, motion, nuisances: Nuisances, used, first, rows, scratch: NuisanceScratch):
    """Add to ``rows`` (readings, columns), from column ``first`` on, what one sd of each nuisance adds to them."""
    read_motion(jaw, motion, scratch.expected)
    copy_rest(jaw, scratch.jaw)
    for j in range(nuisances.reads.shape[0]):
        if not nuisances.reads[j]:
            continue
        change_jaw(jaw, nuisances, j, STEP, scratch.jaw)
        read_motion(scratch.jaw, motion, scratch.changed)
        for i in range(rows.shape[0]):
            if used[i]:
                rows[i, first + j] += (scratch.changed[i] - scratch.expected[i]) / STEP
        turn = nuisances.turn[j]
        turn_readings(turn, -1.0, scratch.expected, scratch.changed)
        for i in range(3, rows.shape[0]):
            if used[i]:
                rows[i, first + j] += scratch.changed[i] - scratch.expected[i]


@njit
def middle_rates(before, after, dt):
    """Mean of the rates over a tick, and their mean rate of change."""
    u = (
        0.5 * (before[5] + after[5]),
        0.5 * (before[6] + after[6]),
        0.5 * (before[7] + after[7]),
        0.5 * (before[8] + after[8]),
        0.5 * (before[9] + after[9]),
    )
    rate = (
        (after[5] - before[5]) / dt,
        (after[6] - before[6]) / dt,
        (after[7] - before[7]) / dt,
        (after[8] - before[8]) / dt,
        (after[9] - before[9]) / dt,
    )
    return u, rate


def _has_memory(settings):
    return settings.typeof("disturbance_variance").shape[0]


def _together(settings):
    return False


@where(_has_memory, otherwise=_together)
def separates_statics(settings: FilterSettings):
    """Whether what a jaw at rest shows of a nuisance is taken apart from the rest: beside a disturbance with memory.

    What lasts shakes the jaw slowly, and servos answer to the true motion. The predicted rates are then correlated with
    the error of the filtered motion: mass, fossa and seat would seem known, and be wrong on one side. So a jaw at rest
    teaches these, and what accelerations show of mass and centre of mass are numbers of their own, which take that
    error. Without memory the way in which a jaw is shaken tells nuisances from muscles.
    """
    return True


def _all_readings(settings):
    return N_MEASUREMENTS


@where(_has_memory, otherwise=_all_readings)
def _readings_of_nuisances(settings: FilterSettings):
    """Number of the readings that a nuisance changes: those of the pose alone where ``separates_statics``."""
    return N_POSE


def set_nuisance_wrenches(jaw: Jaw, muscles, belief: Belief, pose, settings: FilterSettings, scratch):
    """``set_wrenches`` for the filter."""
    first = belief.nominal.shape[0] * belief.nominal.shape[1] + 1
    wrenches = scratch.line_wrench
    last = belief.smoothed
    reading = (last[0], last[1], last[2], last[3], last[4], last[5])
    before, after = scratch.start_motion, scratch.instrument.motion
    u, rate = middle_rates(before, after, settings.dt)
    at = Midway(pose, u, rate, reading, separates_statics(settings))
    set_wrenches(jaw, muscles, at, settings.nuisances, first, wrenches, scratch.nuisances)


def add_nuisance_readings(jaw: Jaw, belief: Belief, settings: FilterSettings, used, scratch):
    """``add_readings`` for the filter."""
    first = belief.nominal.shape[0] * belief.nominal.shape[1] + 1
    rows = scratch.by_tension_rows[: _readings_of_nuisances(settings)]
    add_readings(jaw, belief.predicted, settings.nuisances, used, first, rows, scratch.nuisances)


def correct_samples(jaw: Jaw, belief: Belief, settings: FilterSettings, samples, scratch):
    """Correct the ``samples`` (3, 6) of the force by the nuisances' means."""
    pose, _ = middle_of(jaw, scratch.start_motion, scratch.instrument.motion)
    _correct_offsets(belief, settings.nuisances, pose, samples)
    if has_motors(settings.nuisances):
        correct_motors(jaw, belief, settings, samples, scratch)


def follow_friction(jaw: Jaw, belief: Belief, settings: FilterSettings, scratch):
    """The shares of the motors' friction at the end of a tick, from the motion."""
    if has_motors(settings.nuisances):
        move_friction(jaw, belief, settings, scratch.start_motion)


@njit
def _correct_offsets(belief: Belief, nuisances: Nuisances, pose, samples):
    """Turn the load cell's ``samples`` (3, 6) back and take its offset at a ``pose`` away, as the belief knows both."""
    for j in range(nuisances.mass.shape[0]):
        mean = belief.nuisances[j]
        if not nuisances.in_cell[j]:
            continue
        for i in range(samples.shape[0]):
            turn_wrench(nuisances.cell_turn[j], mean, samples[i])
            add_offset(nuisances.offset[j], -mean, pose, samples[i])


def correct_readings(belief: Belief, nuisances: Nuisances, measured, corrected):
    """``corrected`` (12) = ``measured`` turned back, as far as the belief knows."""
    corrected[:] = measured
    for j in range(nuisances.mass.shape[0]):
        if nuisances.turns[j]:
            turn_readings(nuisances.turn[j], belief.nuisances[j], corrected, corrected)


def begin_jaw(jaw: Jaw, belief: Belief):
    """The filter's own model begins as ``jaw``."""
    copy_jaw(jaw, belief.jaw)


def move_nuisances(belief: Belief, settings: FilterSettings, row, first):
    """Move the nuisances and the filter's model by the steps that ``row`` has from ``first`` on."""
    for k in range(belief.nuisances.shape[0]):
        if separates_statics(settings) and not settings.nuisances.at_rest[k]:
            row[first + k] = 0.0
        belief.nuisances[k] += row[first + k]
    move_jaw(belief.jaw, settings.nuisances, row, first)
