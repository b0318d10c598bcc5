"""The true motion of one tick: the jaw's mechanics under the device, by the plant that the world has.

The plants share one description of the motion: the midline model's coordinates (q, u), and the *lift*, how far the
condyles' midpoint is off the path of the fossa (m) and how fast it leaves it (m/s). In the midline plant the lift is
zero. Plants that Python moves have ``plant_kernel``.

The load cell's amplifier passes the parabola that fits a tick's force best. A brake or an end stop changes its force
several times within a tick. Instantaneous samples would be aliased: three of them miss its mean over a tick by up to a
tenth (Simpson's rule), and the filter would attribute the difference to the muscles. The amplifier therefore averages.
The three samples, at start, middle and end, are those of the least-squares parabola, which has the force's mean and
first two moments.
"""

from __future__ import annotations

from jawenv.device.device import N_MOTORS, TICK, DeviceRecord
from jawenv.device.motors import BRAKED, IDLE, device_wrench, held_rate
from jawenv.envs.world.record import Scratch, Settings, Truth, World
from jawenv.kernels.compiled import njit, njit_inlined, njit_within
from jawenv.kernels.runge_kutta import runge_kutta_step, set_state, stage_place, stage_weight
from jawenv.mechanics.dynamics import state_rate
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import midline_motion, split
from jawenv.mechanics.stiffness import fastest_rate, parts_needed
from jawenv.reality.joint import tissue_push

SUBSTEPS = 2  # Runge-Kutta steps of the midline plant per tick, more where the jaw is stiff


@njit_inlined
def lift_of(truth: Truth):
    """The lift as a tuple."""
    return truth.lift[0], truth.lift[1]


@njit_inlined
def plus_wrench(wrench, extra, push):
    """The device's wrench, the unmodelled one and the push of the reality's tissue on the mouthpiece together."""
    return (
        wrench[0] + extra[0] + push[0],
        wrench[1] + extra[1] + push[1],
        wrench[2] + extra[2] + push[2],
        wrench[3] + extra[3] + push[3],
        wrench[4] + extra[4] + push[4],
        wrench[5] + extra[5] + push[5],
    )


@njit_within
def wrench_at_stage(device: DeviceRecord, world: World, scratch: Scratch, settings: Settings, step, stage, h, motion):
    """The wrench on the jaw at a stage of a Runge-Kutta step, with what the load cell and the governor have of it."""
    since = step * h + stage_place(stage) * h
    wrench, governed = device_wrench(
        device, world.truth.jaw, world.known.limits, world.known.motors, motion, since, settings.control.servo
    )
    scratch.acted = max(scratch.acted, governed)
    add_moments(scratch.wrench, wrench, stage_weight(stage, h) / TICK, 2.0 * since / TICK - 1.0)
    push = tissue_push(settings.reality, world.known.limits, world.truth.jaw, motion[0], motion[2])
    return plus_wrench(wrench, world.truth.unmodelled, push)


@njit_within
def midline_rate(q, u, stage, h, arguments):
    """(q', u') of the midline plant under the device; ``arguments`` as in ``midline_steps``."""
    device, world, scratch, settings, step = arguments
    total = wrench_at_stage(device, world, scratch, settings, step, stage, h, (q, u, lift_of(world.truth)))
    return state_rate(world.truth.jaw, scratch.effective, q, u, total)


@njit
def midline_tick(device: DeviceRecord, world: World, scratch: Scratch, settings: Settings):
    """Move the midline plant through one tick; returns what of the governor acted (``device_wrench``).

    Stops and brake are so stiff that the usual steps are unstable, and work seldom: the steps are as short as what
    acted in the last tick asks for. Where something stiffer begins to act, the tick is taken again. The usual steps
    bear the motors' servos.
    """
    truth = world.truth
    q, u = split(truth.state)
    rate = fastest_rate(truth.jaw, scratch.effective, q)
    parts = _parts_of_tick(device, truth.jaw, settings, rate, truth.acted)
    acted = midline_steps(device, world, scratch, settings, parts)
    shorter = _parts_of_tick(device, truth.jaw, settings, rate, acted)
    if shorter > parts:
        set_state(world.truth.state, q, u)
        acted = midline_steps(device, world, scratch, settings, shorter)
    truth.acted = acted
    return acted


@njit
def _parts_of_tick(device: DeviceRecord, jaw: Jaw, settings: Settings, rate, acted):
    """Runge-Kutta steps in a tick of a jaw with this free ``rate`` (1/s), where this of the governor ``acted``."""
    if acted >= BRAKED:
        rate = held_rate(device, jaw, settings.control.servo, acted, rate)
    return parts_needed(rate, TICK, SUBSTEPS)


@njit
def midline_steps(device: DeviceRecord, world: World, scratch: Scratch, settings: Settings, parts):
    """One tick of the midline plant in so many Runge-Kutta steps; returns what of the governor acted."""
    h = TICK / parts
    scratch.acted = IDLE
    clear_moments(scratch.wrench)
    for step in range(parts):
        q, u = split(world.truth.state)
        q, u = runge_kutta_step(midline_rate, q, u, h, (device, world, scratch, settings, step))
        set_state(world.truth.state, q, u)
    return scratch.acted


@njit
def take_free_body(truth: Truth, body_q, body_u):
    """Set the midline coordinates and the lift of ``truth`` from the motion (6, 6) of a free mandible."""
    q, u, lift, lift_rate = midline_motion(truth.jaw, body_q, body_u)
    set_state(truth.state, q, u)
    truth.lift[0], truth.lift[1] = lift, lift_rate


@njit
def end_motion(device: DeviceRecord, world: World, scratch: Scratch, trajectory):
    """The load cell's samples of the tick that has passed, and the motors' targets where they have moved to."""
    truth, known = world.truth, world.known
    q, u = split(truth.state)
    _, governed = device_wrench(device, truth.jaw, known.limits, known.motors, (q, u, lift_of(truth)), TICK, trajectory)
    take_samples(scratch.wrench)
    if trajectory:
        for i in range(N_MOTORS):
            known.motors.target[i] += known.motors.rate[i] * TICK
    return governed


@njit
def true_motion(device: DeviceRecord, world: World, scratch: Scratch, settings: Settings):
    """Move the jaw through one tick; samples the device's wrench, returns what of the governor acted."""
    acted = midline_tick(device, world, scratch, settings)
    return max(acted, end_motion(device, world, scratch, settings.control.servo))


@njit
def clear_moments(samples):
    """Set the moments of a new tick to zero."""
    samples[:, :] = 0.0


@njit
def add_moments(samples, wrench, share, time):
    """Add the wrench of a ``share`` of the tick, which lies at ``time``, from -1 at its start to 1 at its end.

    Until ``take_samples``, the rows of ``samples`` (3, 6) are the force's parts along Legendre's polynomials 1, x and
    (3 x^2 - 1)/2.
    """
    first, second = 3.0 * share * time, 2.5 * share * (3.0 * time * time - 1.0)
    for k in range(6):
        samples[0, k] += share * wrench[k]
        samples[1, k] += first * wrench[k]
        samples[2, k] += second * wrench[k]


@njit
def take_samples(samples):
    """Samples of the parabola at start, middle and end of the tick."""
    for k in range(6):
        mean, rise, bend = samples[0, k], samples[1, k], samples[2, k]
        samples[0, k], samples[1, k], samples[2, k] = mean - rise + bend, mean - 0.5 * bend, mean + rise + bend
