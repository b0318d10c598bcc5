"""Nuisances of a force that no load cell reads (``device.force_sensor``): gain, friction and direction of each motor.

What is read is a wrench, of which the four motors' forces follow. It is corrected by the nuisances' means before the
motion takes the tick; the columns are what one sd of each makes of the forces as the sensors read them.
"""

from __future__ import annotations

from jawenv.device.device import N_MOTORS
from jawenv.device.force_sensor import error_wrench, motor_forces, motor_rates, moving_motors, read_forces
from jawenv.filter.belief.state import Belief, FilterSettings, Nuisances
from jawenv.kernels.compiled import njit
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import rotation, split


@njit
def has_motors(nuisances: Nuisances):
    """Whether no load cell reads the force."""
    return nuisances.linkage.point[0, 1] > 0.0


@njit
def motors_of(nuisances: Nuisances, jaw: Jaw, at, scratch):
    """(forces as their sensors read them, shares of friction, rates), four each, for a corrected reading.

    Zeros where a load cell reads the force; ``at`` is (pose, rates, rotation, reading).
    """
    pose, u, body_to_head, reading = at
    share = scratch.friction_share
    shares = share[0], share[1], share[2], share[3]
    if not has_motors(nuisances):
        return (0.0, 0.0, 0.0, 0.0), shares, (0.0, 0.0, 0.0, 0.0)
    rates = motor_rates(nuisances.linkage, jaw, pose, u)
    forces = motor_forces(nuisances.linkage, body_to_head, reading)
    return read_forces(scratch.motor_errors, forces, shares, rates), shares, rates


@njit
def set_motor_column(nuisances: Nuisances, j, at, column, line_wrench):
    """The column of a nuisance of a force that no load cell reads; ``at`` is (rotation, ``motors_of``)."""
    body_to_head, motors = at
    force, moment = error_wrench(nuisances.linkage, nuisances.motor_errors[j], motors, body_to_head)
    for i in range(3):
        line_wrench[i, column], line_wrench[3 + i, column] = force[i], moment[i]


@njit
def correct_motors(jaw: Jaw, belief: Belief, settings: FilterSettings, samples, scratch):
    """Add to ``samples`` (3, 6) what acts beyond what is read, as far as the belief knows it.

    ``scratch`` is that of the time update, with the motion at the start of the tick and what the past alone predicts.
    """
    nuisances, errors = settings.nuisances, scratch.nuisances.motor_errors
    errors[:, :] = 0.0
    for j in range(nuisances.of_motors.shape[0]):
        if nuisances.of_motors[j]:
            for i in range(errors.shape[0]):
                for k in range(errors.shape[1]):
                    errors[i, k] += belief.nuisances[j] * nuisances.motor_errors[j, i, k]
    q, u = split(scratch.start_motion)
    body_to_head, first = rotation(q), motor_rates(nuisances.linkage, jaw, q, u)
    q, u = split(scratch.instrument.motion)
    last = motor_rates(nuisances.linkage, jaw, q, u)
    for i in range(samples.shape[0]):
        shares, rates = moving_motors(belief.friction_share, first, last, 0.5 * i, settings.dt)
        forces = motor_forces(nuisances.linkage, body_to_head, samples[i])
        force, moment = error_wrench(nuisances.linkage, errors, (forces, shares, rates), body_to_head)
        for k in range(3):
            samples[i, k] += force[k]
            samples[i, 3 + k] += moment[k]
    half_way, _ = moving_motors(belief.friction_share, first, last, 0.5, settings.dt)
    for i in range(N_MOTORS):
        scratch.nuisances.friction_share[i] = half_way[i]


@njit
def move_friction(jaw: Jaw, belief: Belief, settings: FilterSettings, before):
    """``friction_share`` after a tick from the motion ``before`` to the present one."""
    linkage = settings.nuisances.linkage
    q, u = split(before)
    first = motor_rates(linkage, jaw, q, u)
    q, u = split(belief.motion)
    last = motor_rates(linkage, jaw, q, u)
    after, _ = moving_motors(belief.friction_share, first, last, 1.0, settings.dt)
    for i in range(N_MOTORS):
        belief.friction_share[i] = after[i]
