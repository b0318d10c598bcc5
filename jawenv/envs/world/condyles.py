"""A jaw on one point or on two condyles: the plant and its rest, chosen from the type of a world.

``truth.body`` has no numbers in a world whose plant is not the one with two condyles. What is then never called is not
compiled either.
"""

from __future__ import annotations

from jawenv.device.comfort import Limits
from jawenv.device.device import DeviceRecord
from jawenv.device.motors import mouthpiece_motion
from jawenv.envs.world.plants import bilateral_tick, end_motion, lift_of, midline_tick, take_body
from jawenv.envs.world.record import Scratch, Settings, Truth, World
from jawenv.kernels.compiled import njit, where
from jawenv.mechanics.bilateral import put_on_fossa, settle_bilateral
from jawenv.mechanics.kinematics import rotation, split

# A jaw that rests outside this box is not one that the device can treat.
REST_OPENING_MAX = 0.035
REST_SIDE_MAX = 0.005


def _midline(device: DeviceRecord, world: World, scratch: Scratch, settings: Settings):
    return midline_tick(device, world, scratch, settings)


@where(lambda world: world.typeof("truth").typeof("body").shape[0], otherwise=_midline)
def _plant_tick(device: DeviceRecord, world: World, scratch: Scratch, settings: Settings):
    """One tick: of a world that has a body, whose jaw may all the same be believed to have one point (planners)."""
    if world.truth.jaw.condyles == 2:
        return bilateral_tick(device, world, scratch, settings)
    return midline_tick(device, world, scratch, settings)


@njit
def true_motion(device: DeviceRecord, world: World, scratch: Scratch, settings: Settings):
    """Move the jaw through one tick; samples the device's wrench, returns what of the governor acted."""
    acted = _plant_tick(device, world, scratch, settings)
    return max(acted, end_motion(device, world, scratch, settings.control.servo))


def _rest_on_one_point(truth: Truth, limits: Limits, scratch):
    return True  # the midline model's rest is the plant's own


@where(lambda truth: truth.typeof("body").shape[0], otherwise=_rest_on_one_point)
def rest_on_condyles(truth: Truth, limits: Limits, scratch):
    """Move the jaw of a world with a body to its rest on two condyles; False when that is out of reach."""
    jaw = truth.jaw
    put_on_fossa(jaw, truth.state, truth.body)
    no_wrench = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    if not settle_bilateral(jaw, truth.muscles, no_wrench, truth.body, scratch.body_matrix, scratch.body_right):
        return False
    take_body(truth)
    return count_from_rest(truth, limits)


@njit
def count_from_rest(truth: Truth, limits: Limits):
    """Count the limits, which keep their widths, from where the jaw rests; whether the device can treat it there."""
    q, u = split(truth.state)
    point, _ = mouthpiece_motion(truth.jaw, q, u, lift_of(truth), rotation(q))
    limits.rest_opening = truth.jaw.mouthpiece[2] - point[2]
    limits.rest_side = point[1]
    limits.rest_condyle_side = q[1]
    limits.path[0] = point[0]
    return limits.rest_opening <= REST_OPENING_MAX and abs(limits.rest_side) <= REST_SIDE_MAX
