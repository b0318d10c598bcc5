"""Observation of a policy of targets control in the twin: the environment's observation without its noise."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from agents.twin.worlds import Worlds
from jawenv.envs.observation import FORCE_SCALE, MOMENT_SCALE, OBSERVATION_BOUND, POSE_SCALE, RANGE_SCALE, RATE_SCALE


def observation(worlds: Worlds, time_left: float, asked: bool = False, correlations: bool = False) -> Tensor:
    """Rows (P, size) in the order of ``jawenv.envs.observation.observation_layout``.

    Args:
        worlds: of the twin.
        time_left: share of the episode.
        asked: whether muscles are asked for.
        correlations: whether those of the belief end it.
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
    parts = (
        (worlds.belief.mean - twin.prior_mean) / twin.prior_sd,
        (sd / twin.prior_sd).log() / math.log(10.0),
        q / q.new_tensor(POSE_SCALE),
        torch.cat([speeds[:, :2], omega], -1) / q.new_tensor(RATE_SCALE),
        torch.stack(worlds.felt(), -1) / used,
        used / q.new_tensor(RANGE_SCALE),
        felt[0] / FORCE_SCALE,
        felt[1] / MOMENT_SCALE,
        worlds.thrust / (twin.reach * twin.servo),
        worlds.size * worlds.kept * worlds.target,
        worlds.margin,
        q.new_full((len(q), 1), time_left),
    )
    end: tuple[Tensor, ...] = (worlds.asked, worlds.discomfort[:, None]) if asked else ()
    if twin.budget > 0.0 and not asked:
        end = (worlds.discomfort[:, None] / twin.budget,)
    if correlations:
        rows, columns = torch.triu_indices(12, 12, 1, device=q.device)
        covariance = worlds.belief.covariance
        end = (*end, covariance[:, rows, columns] / (sd[:, rows] * sd[:, columns]))
    return torch.cat([*parts, *end], -1).clamp(-OBSERVATION_BOUND, OBSERVATION_BOUND)
