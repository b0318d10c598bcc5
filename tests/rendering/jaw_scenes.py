"""Scenes of any model made by hand, and what the tests look for in their pictures."""

import dataclasses

import numpy as np

from jawenv.anatomy import default_fossa, default_mandible
from jawenv.ladder import MODELS
from jawenv.rendering.scene import Scene

LIMITS = ("force", "opening", "side", "fore_aft", "condyle_fore_aft", "condyle_side", "speed", "tension")

# Parts of the default picture, 1280 by 720: rows, then columns.
SIDE = np.s_[90:470, 20:396]
FRONT = np.s_[90:470, 416:794]
POSTERIOR = np.s_[110:480, 816:1260]
COMFORT = np.s_[566:700, 20:396]
TRACE = np.s_[560:680, 460:790]


def rotation(opening: float, yaw: float = 0.0) -> np.ndarray:
    c, s = np.cos(opening), np.sin(opening)
    cy, sy = np.cos(yaw), np.sin(yaw)
    pitch = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    return pitch @ np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])


def scene(
    opening: float = 0.1,
    yaw: float = 0.0,
    sd: float = 0.2,
    time_s: float = 3.0,
    model: str = "jaw",
    lift_m: float = 0.0,
    **changes: object,
) -> Scene:
    """A scene of any model; `lift_m` raises the point between the condyles above their path."""
    muscles, mandible, fossa = MODELS[model].muscles, default_mandible(), default_fossa()
    turn = rotation(opening, yaw)
    x = 0.02 * opening if MODELS[model].free[0] else 0.0
    contact = np.array([x, 0.0, fossa.drop_m * (np.cos(fossa.spatial_frequency * x) - 1) + lift_m])
    mouthpiece = contact + turn @ np.asarray(mandible.mouthpiece_m)
    opening_mm = 1000 * float(mandible.mouthpiece_m[2] - mouthpiece[2])
    prior_mean, prior_sd = np.log(np.tile([1.2, 7.0], len(muscles))), np.tile([0.5, 0.3], len(muscles))
    whole = Scene(
        muscle_names=tuple(muscles.names[i] for i in muscles.muscle),
        muscle_origin_m=muscles.origin_m,
        muscle_insertion_m=contact + muscles.insertion_m @ turn.T,
        muscle_tension_N=np.resize([1.0, 2.0, 0.5, 4.0, 8.0, 0.1], len(muscles.muscle)),
        contact_m=contact,
        rotation=turn,
        plant=MODELS[model].plant,
        slides=MODELS[model].free[0],
        condyle_half_width_m=mandible.condyle_half_width_m,
        fossa_drop_m=fossa.drop_m,
        fossa_frequency=fossa.spatial_frequency,
        mouthpiece_m=mouthpiece,
        mouthpiece_force_N=np.array([2.0, 0.0, -9.0]),
        parameter_names=muscles.parameter_names,
        belief_mean=prior_mean + 0.1,
        belief_cov=np.eye(2 * len(muscles)) * sd**2,
        prior_mean=prior_mean,
        prior_sd=prior_sd,
        truth=prior_mean + 0.3,
        comfort=dict.fromkeys(LIMITS, 0.4),
        comfort_hard=dict.fromkeys(LIMITS, 1.3),
        governor=0.0,
        time_s=time_s,
        episode_s=30.0,
        opening_mm=opening_mm,
        opening_limits_mm=np.array([25.0, 32.0]),
        excursion_mm=np.array([95.0 * yaw, 1.0]),
        excursion_soft_mm=np.array([5.0, 4.5]),
        information_nats=12.0,
        title="A test",
    )
    return dataclasses.replace(whole, **changes)


def differ(one: np.ndarray, other: np.ndarray, part: tuple) -> int:
    return int((one[part] != other[part]).any(axis=-1).sum())


def coloured(picture: np.ndarray, part: tuple, colour: tuple[int, int, int]) -> int:
    return int((np.abs(picture[part].astype(int) - colour).max(axis=-1) <= 3).sum())
