"""A jaw on one point or on two condyles: the plant and its rest, chosen from the type of a world.

``truth.body`` has no numbers in a world whose plant is not the one with two condyles. What is then never called is not
compiled either.
"""

from __future__ import annotations

from jawenv.device.comfort import Limits
from jawenv.device.device import DeviceRecord
from jawenv.device.motors import mouthpiece_motion
from jawenv.envs.world.plants import end_motion, lift_of, midline_tick
from jawenv.envs.world.record import Scratch, Settings, Truth, World
from jawenv.kernels.compiled import njit, where
from jawenv.mechanics.kinematics import rotation, split

# A jaw that rests outside this box is not one that the device can treat.
REST_OPENING_MAX = 0.035
REST_SIDE_MAX = 0.005


def _on_one_point(world):
    return not world.typeof("truth").typeof("body").shape[0]


@where(_on_one_point, otherwise="jawenv.envs.world.two_condyles.plant_tick")
def _plant_tick(device: DeviceRecord, world: World, scratch: Scratch, settings: Settings):
    """One tick of the world's plant."""
    return midline_tick(device, world, scratch, settings)


@njit
def true_motion(device: DeviceRecord, world: World, scratch: Scratch, settings: Settings):
    """Move the jaw through one tick; samples the device's wrench, returns what of the governor acted."""
    acted = _plant_tick(device, world, scratch, settings)
    return max(acted, end_motion(device, world, scratch, settings.control.servo))


@where(lambda truth: not truth.typeof("body").shape[0], otherwise="jawenv.envs.world.two_condyles.settle_on_condyles")
def rest_on_condyles(truth: Truth, limits: Limits, scratch):
    """Move the jaw of a world with a body to its rest on two condyles; False when that is out of reach."""
    return True  # the midline model's rest is the plant's own


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
