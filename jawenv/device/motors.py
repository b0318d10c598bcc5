"""Motors, servo and governor: from the action to the wrench on the mouthpiece.

Each 10 ms the motors take their command (slew limit, lag, thrust-speed curve, heat). Between, the wrench follows the
motion continuously: the position servo of trajectory control, the cap on the force, and the governor.

The governor sits in the linkage and serves every agent alike: adjustable end stops between the soft and the hard limit
for opening, side and fore-aft travel of the mouthpiece and for travel of the condyles (the linkage turns about their
axis and slides with it, so a stop of its slide acts there), a brake above the soft speed, and a lower cap on the force.
While a stop or the brake works, the motors yield to it. The governor does not know the tension of muscles.

How stiff all this makes the jaw bounds the steps of its motion (``held_rate``, as ``mechanics.stiffness``): stiffness k
and damping d at a point of mobility w add k w and d w to bounds K and D of the body's. Motors that yield to stops and
brake add their thrust's share of both, across its own direction: the sums are not symmetric, and a mode x'' + d_x x' +
k_x x = 0 with |k_x| <= K and |d_x| <= D is no faster than the root of x^2 = D x + K.
"""

from __future__ import annotations

from math import exp, sqrt
from typing import Annotated

from jawenv.device.comfort import (
    CONDYLE_FORE_AFT,
    CONDYLE_SIDE,
    FORCE,
    FORE_AFT,
    OPENING,
    SIDE,
    SPEED,
    Limits,
    excursions,
)
from jawenv.device.device import N_MOTORS, DeviceRecord, Linkage
from jawenv.kernels.compiled import njit, njit_inlined
from jawenv.kernels.lanes import all_lines
from jawenv.kernels.records import Array
from jawenv.kernels.vec3 import add, apply, apply_transposed, cross, dot, norm, row3, scale, subtract, vector3
from jawenv.mechanics.forces import smooth_ramp, totals
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import contact_point, fossa, rotation

ON_PATH = (0.0, 0.0)  # lift of a jaw whose condyles' midpoint is on its path
STOP_ONSET_WIDTH = 0.5e-3
# What of the governor acts, by growing stiffness.
IDLE, CAPPED, BRAKED, STOPPED, STOPPED_AND_BRAKED = 0.0, 1.0, 2.0, 3.0, 4.0
YIELD_FORCE = 8.0  # N of stops and brake at which the motors have yielded altogether


class Motors:
    """The motors."""

    thrust: Annotated[Array, N_MOTORS]
    command: Annotated[Array, N_MOTORS]
    target: Annotated[Array, N_MOTORS]
    rate: Annotated[Array, N_MOTORS]
    cap: Annotated[Array, N_MOTORS]
    heat: Annotated[Array, N_MOTORS]


@njit_inlined
def motor_point(device: DeviceRecord | Linkage, jaw: Jaw, i, body_to_head, mouthpiece, velocity, omega):
    """Arm from the mouthpiece (head axes), position along the motor's axis and its rate, for motor i, or all."""
    point = row3(device.point, i)
    arm = apply(body_to_head, point)
    axis = row3(device.direction, i)
    position = dot(axis, add(mouthpiece, arm)) - dot(axis, add(vector3(jaw.mouthpiece), point))
    rate = dot(axis, add(velocity, apply(body_to_head, cross(omega, point))))
    return arm, axis, position, rate


@njit_inlined
def mouthpiece_motion(jaw: Jaw, q, u, lift, body_to_head):
    """Place and velocity of the mouthpiece in head axes.

    ``lift`` is what the condyles' midpoint is above its path (m), and its rate (m/s): zero in the midline model.
    """
    arm = vector3(jaw.mouthpiece)
    _, slope, _, _ = fossa(jaw, q[0])
    point = add(add(contact_point(jaw, q), (0.0, 0.0, lift[0])), apply(body_to_head, arm))
    spin = cross((u[2], u[3], u[4]), arm)
    return point, add((u[0], u[1], slope * u[0] + lift[1]), apply(body_to_head, spin))


@njit
def command_motors(device: DeviceRecord, jaw: Jaw, motors: Motors, motion, action, trajectory, dt):
    """Take the action (4, in [-1, 1]) for the next ``dt``: new thrust or target rate, cap and heat of each motor.

    ``motion`` is (q, u, lift), as ``envs.world.plants`` describes it.
    """
    q, u, lift = motion
    body_to_head = rotation(q)
    point, velocity = mouthpiece_motion(jaw, q, u, lift, body_to_head)
    follow = 1.0 - exp(-dt / device.lag)
    for i in range(N_MOTORS):
        _, _, position, rate = motor_point(device, jaw, i, body_to_head, point, velocity, (u[2], u[3], u[4]))
        limit = device.thrust_peak if motors.heat[i] < 1.0 else device.thrust_continuous
        limit = limit * max(0.0, 1.0 - abs(rate) / device.no_load_speed)
        motors.cap[i] = limit
        if trajectory:
            motors.rate[i] += follow * (action[i] * device.max_rate - motors.rate[i])
            # A target farther away than the servo can pull would only wind up.
            reach = device.full_scale / device.servo_stiffness
            low, high = position - reach - motors.rate[i] * dt, position + reach - motors.rate[i] * dt
            motors.target[i] = min(max(motors.target[i], low), high)
        else:
            step = device.slew * dt
            goal = action[i] * device.full_scale
            motors.command[i] += min(max(goal - motors.command[i], -step), step)
            motors.thrust[i] += follow * (motors.command[i] - motors.thrust[i])
            motors.thrust[i] = min(max(motors.thrust[i], -limit), limit)
        load = motors.thrust[i] / device.thrust_continuous
        motors.heat[i] += (load * load - motors.heat[i]) * dt / device.thermal_time


@njit_inlined
def device_wrench(device: DeviceRecord, jaw: Jaw, limits: Limits, motors: Motors, motion, since, trajectory):
    """Wrench on the mouthpiece (force and moment, body axes) ``since`` seconds after the command, and what acted.

    ``motion`` is (q, u, lift), as ``envs.world.plants`` describes it. The last value says what of the governor acts:
    ``IDLE``, ``CAPPED``, ``BRAKED`` and so on.
    """
    q, u, lift = motion
    body_to_head = rotation(q)
    point, velocity = mouthpiece_motion(jaw, q, u, lift, body_to_head)
    omega = (u[2], u[3], u[4])
    all_motors = all_lines(motors.thrust)
    arm, axis, position, rate = motor_point(device, jaw, all_motors, body_to_head, point, velocity, omega)
    thrust = motors.thrust[all_motors]
    if trajectory:
        lead = motors.target[all_motors] + motors.rate[all_motors] * since - position
        thrust = device.servo_stiffness * lead + device.servo_damping * (motors.rate[all_motors] - rate)
        thrust = min(max(thrust, -motors.cap[all_motors]), motors.cap[all_motors])
        motors.thrust[all_motors] = thrust
    pushes = scale(thrust, axis)
    force, moment = totals(pushes), totals(cross(arm, pushes))
    stops = _end_stops(device, jaw, limits, point, velocity)
    slide = _condyle_stop(device, limits, q, u)
    pressed = norm(stops) + norm(slide)
    acted = STOPPED if pressed > 0.0 else IDLE
    speed, brake_onset = norm(velocity), limits.speed * limits.onset[SPEED]
    if speed > brake_onset and device.brake > 0.0:
        acted = STOPPED_AND_BRAKED if acted == STOPPED else BRAKED
        braking = scale(-device.brake * (speed - brake_onset) / speed, velocity)
        stops = add(stops, braking)
        pressed = norm(stops) + norm(slide)
    strength = norm(force)
    governed = min(limits.force * limits.onset[FORCE], device.force_cap)
    share = max(0.0, 1.0 - pressed / YIELD_FORCE)
    if strength > governed:
        acted = max(acted, CAPPED)
        share *= governed / strength
    # A stop of the slide pushes along the condyles' axis: at the mouthpiece this is the same force and a moment.
    lever = apply(body_to_head, vector3(jaw.mouthpiece))
    force = apply_transposed(body_to_head, add(scale(share, force), add(stops, slide)))
    moment = apply_transposed(body_to_head, subtract(scale(share, moment), cross(lever, slide)))
    return (force[0], force[1], force[2], moment[0], moment[1], moment[2]), acted


@njit_inlined
def _end_stop(device: DeviceRecord, travel, limit, rate):
    """Push back of a one-sided stop at ``limit`` (0 or less inside)."""
    ramp, steepness = smooth_ramp(travel - limit, STOP_ONSET_WIDTH)
    return max(0.0, device.stop_stiffness * ramp + device.stop_damping * steepness * rate)


@njit_inlined
def _end_stops(device: DeviceRecord, jaw: Jaw, limits: Limits, point, velocity):
    """Force of the mouthpiece's stops (head axes); zero inside their travel."""
    opening, side, fore_aft = excursions(limits, jaw, point)
    side_limit = limits.side * limits.onset[SIDE]
    forward_limit = limits.fore_aft * limits.onset[FORE_AFT]
    up = _end_stop(device, opening, limits.opening * limits.onset[OPENING], -velocity[2])
    left = _end_stop(device, -side, side_limit, -velocity[1]) - _end_stop(device, side, side_limit, velocity[1])
    forward = _end_stop(device, -fore_aft, forward_limit, -velocity[0])
    forward -= _end_stop(device, fore_aft, forward_limit, velocity[0])
    return (forward, left, up)


@njit_inlined
def _condyle_stop(device: DeviceRecord, limits: Limits, q, u):
    """Force of the slide's stops on the condyles (head axes); zero inside their travel."""
    x, y = q[0] - limits.condyle_middle, q[1] - limits.rest_condyle_side
    forward_limit = limits.condyle_half * limits.onset[CONDYLE_FORE_AFT]
    side_limit = limits.condyle_side * limits.onset[CONDYLE_SIDE]
    forward = _end_stop(device, -x, forward_limit, -u[0]) - _end_stop(device, x, forward_limit, u[0])
    left = _end_stop(device, -y, side_limit, -u[1]) - _end_stop(device, y, side_limit, u[1])
    return (forward, left, 0.0)


@njit
def held_rate(device: DeviceRecord, jaw: Jaw, trajectory, acted, free_rate):
    """Bound on the rate (1/s) of a jaw of this ``free_rate``, while the device holds it.

    Args:
        device: Record of dtype ``DEVICE``.
        jaw: Record of dtype ``jaw_dtype``.
        trajectory: Whether position servos act.
        acted: What of the governor acts, as ``motors.device_wrench`` returns it.
        free_rate: Bound on the rate without the device (1/s).
    """
    stiffness, damping = free_rate * free_rate, 0.0
    # Half of the motors pull along the same line.
    abreast = 0.5 * N_MOTORS
    yielding = 1.0 + abreast * device.full_scale / YIELD_FORCE
    if acted == BRAKED or acted == STOPPED_AND_BRAKED:
        damping += yielding * jaw.mouthpiece_mobility * device.brake
    if acted >= STOPPED:
        stops = yielding * (jaw.mouthpiece_mobility + jaw.condyle_mobility)
        stiffness += stops * device.stop_stiffness
        damping += stops * device.stop_damping
    if trajectory:
        motors = abreast * jaw.mouthpiece_mobility
        stiffness += motors * device.servo_stiffness
        damping += motors * device.servo_damping
    return 0.5 * (damping + sqrt(damping * damping + 4.0 * stiffness))
