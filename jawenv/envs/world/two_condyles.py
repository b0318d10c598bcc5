"""The plant with two condyles: its tick and its rest; ``condyles`` names them."""

from __future__ import annotations

from jawenv.device.comfort import Limits
from jawenv.device.device import TICK, DeviceRecord
from jawenv.device.motors import IDLE
from jawenv.envs.world.condyles import count_from_rest
from jawenv.envs.world.plants import clear_moments, midline_tick, take_body, wrench_at_stage
from jawenv.envs.world.record import Scratch, Settings, Truth, World
from jawenv.kernels.compiled import njit, njit_within
from jawenv.kernels.runge_kutta import runge_kutta_step, set_state
from jawenv.mechanics.bilateral import BODY_STEP, bilateral_rate, put_on_fossa, settle_bilateral
from jawenv.mechanics.kinematics import midline_motion, split_body

BODY_SUBSTEPS = round(TICK / BODY_STEP)


@njit_within
def body_rate(q, u, stage, h, arguments):
    """(q', u') of the plant with two condyles under the device; ``arguments`` as in ``_bilateral_tick``."""
    device, world, scratch, settings, step = arguments
    middle_q, middle_u, lift, lift_rate = midline_motion(world.truth.jaw, q, u)
    motion = middle_q, middle_u, (lift, lift_rate)
    total = wrench_at_stage(device, world, scratch, settings, step, stage, h, motion)
    return bilateral_rate(world.truth.jaw, scratch.effective, q, u, total)


@njit
def _bilateral_tick(device: DeviceRecord, world: World, scratch: Scratch, settings: Settings):
    """Move the plant with two condyles through one tick; returns what of the governor acted."""
    h = TICK / BODY_SUBSTEPS
    scratch.acted = IDLE
    clear_moments(scratch.wrench)
    for step in range(BODY_SUBSTEPS):
        q, u = split_body(world.truth.body)
        q, u = runge_kutta_step(body_rate, q, u, h, (device, world, scratch, settings, step))
        set_state(world.truth.body, q, u)
    take_body(world.truth)
    return scratch.acted


def plant_tick(device: DeviceRecord, world: World, scratch: Scratch, settings: Settings):
    """One tick: of a world that has a body, whose jaw may all the same be believed to have one point (planners)."""
    if world.truth.jaw.condyles == 2:
        return _bilateral_tick(device, world, scratch, settings)
    return midline_tick(device, world, scratch, settings)


def settle_on_condyles(truth: Truth, limits: Limits, scratch):
    """Move the jaw of a world with a body to its rest on two condyles; False when that is out of reach."""
    jaw = truth.jaw
    put_on_fossa(jaw, truth.state, truth.body)
    no_wrench = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if not settle_bilateral(jaw, truth.muscles, no_wrench, truth.body, scratch.body_matrix, scratch.body_right):
        return False
    take_body(truth)
    return count_from_rest(truth, limits)
