"""What a hand-made maneuver reads from an observation, back in physical units."""

from typing import NamedTuple

import numpy as np

from agents.protocol import Array, Observation
from jawenv.anatomy import default_fossa
from jawenv.device.comfort import SOFT_FORCE
from jawenv.envs.observation import (
    POSE_SCALE,
    RANGE_SCALE,
    observation_layout,
    parameters_of,
)
from jawenv.errors import InputError

CREST_M = np.pi / default_fossa().spatial_frequency


class Observed(NamedTuple):
    """Parts of N observations.

    Attributes:
        jaw: (N, 3) opening, side and fore-aft place as signed fractions of their soft limits, 0 at rest.
        range_mm: (N, 3) those limits.
        pitch, roll: (N,) filtered angles, rad.
        condyle: (N,) filtered place of the condyles on their way to the crest of the eminence, 0 to 1.
        forward_N, down_N: (N,) force of the device on the jaw along the head's axes, by the load cell.
        margin: (N, 8) what is left of each comfort limit, negative beyond it.
    """

    jaw: Array
    range_mm: Array
    pitch: Array
    roll: Array
    condyle: Array
    forward_N: Array
    down_N: Array
    margin: Array


def read(observation: Observation) -> Observed:
    """Take N observations (N, size) apart, of any of jawenv's models.

    Raises:
        InputError: an observation of another size, or one that is not finite.
    """
    if observation.ndim != 2:
        raise InputError(f"observation has shape {observation.shape}, allowed are (N, size) and (size,)")
    layout = observation_layout(parameters_of(observation.shape[1]))
    if not np.isfinite(observation).all():
        raise InputError("observation holds a value that is not finite")
    part = {name: observation[:, place].astype(float) for name, place in layout.items()}
    pose = part["pose"] * POSE_SCALE
    pitch = pose[:, 2]
    # The cell sits in the mouthpiece and turns with it; the motors push along the head's axes.
    force = part["force"] * SOFT_FORCE
    return Observed(
        jaw=part["jaw"],
        range_mm=part["jaw_range"] * RANGE_SCALE * 1e3,
        pitch=pitch,
        roll=pose[:, 4],
        condyle=pose[:, 0] / CREST_M,
        forward_N=np.cos(pitch) * force[:, 0] + np.sin(pitch) * force[:, 2],
        down_N=np.sin(pitch) * force[:, 0] - np.cos(pitch) * force[:, 2],
        margin=part["comfort_margin"],
    )
