"""Observation of a policy of targets control in the twin: the environment's observation without its noise."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from agents.twin.worlds import Worlds
from jawenv.base.errors import InputError
from jawenv.envs.observation import (
    FORCE_SCALE,
    MOMENT_SCALE,
    OBSERVATION_BOUND,
    POSE_SCALE,
    RANGE_SCALE,
    RATE_SCALE,
    Parts,
)


def observation(worlds: Worlds, time_left: float, parts: Parts) -> Tensor:
    """Rows (P, size) of the environment's parts, in their order.

    Args:
        worlds: of the twin.
        time_left: share of the episode.
        parts: of the environment's observation.

    Raises:
        InputError: a part that the twin does not have.
    """
    twin, p, q = worlds.twin, worlds.patients, worlds.pose.q
    sd = worlds.belief.covariance.diagonal(dim1=-2, dim2=-1)[:, :12].sqrt()
    used = torch.stack([p.opening, p.side, p.fore_aft], -1)
    speeds = worlds.speeds
    omega = torch.einsum("nji,nkj,nk->ni", worlds.pose.turned, worlds.pose.twists[:, 2:, 3:], speeds[:, 2:])
    push = worlds.thrust[..., None] * twin.directions
    force = push.sum(1)
    moment = torch.linalg.cross(worlds.motor_arms - worlds.arm[:, None, :], push).sum(1)
    body = worlds.pose.turned.mT
    felt = [(body @ vector[..., None])[..., 0] for vector in (force, moment)]
    values = {
        "belief_mean": (worlds.belief.mean - twin.prior_mean) / twin.prior_sd,
        "belief_sd": (sd / twin.prior_sd).log() / math.log(10.0),
        "pose": q / q.new_tensor(POSE_SCALE),
        "rates": torch.cat([speeds[:, :2], omega], -1) / q.new_tensor(RATE_SCALE),
        "jaw": torch.stack(worlds.felt(), -1) / used,
        "jaw_range": used / q.new_tensor(RANGE_SCALE),
        "force": torch.cat([felt[0] / FORCE_SCALE, felt[1] / MOMENT_SCALE], -1),
        "motor_thrust": worlds.thrust / (twin.reach * twin.servo),
        "motor_target": worlds.size * worlds.kept * worlds.target,
        "comfort_margin": worlds.margin,
        "time_left": q.new_full((len(q), 1), time_left),
        "asked": worlds.asked,
        "discomfort": worlds.discomfort[:, None],
        "spent": worlds.discomfort[:, None] / (twin.budget or math.inf),
    }
    for name in parts.layout.keys() - values.keys():
        raise InputError(f"the observation has a part {name!r}; allowed in the twin: {', '.join(values)}")
    return torch.cat([values[name] for name in parts.layout], -1).clamp(-OBSERVATION_BOUND, OBSERVATION_BOUND)
