"""The info dictionary: belief, truth, discomfort and information of one world or of N."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.device.comfort import COMFORT_LIMITS
from jawenv.envs.plants import TICK

_COST_KEYS = tuple(f"cost_{name}" for name in COMFORT_LIMITS)


def describe(worlds: Any, parameter_names: tuple[str, ...], with_bound: bool) -> dict[str, Any]:
    """Fresh info of one record of dtype ``world_dtype``, or of an array of N of them with N leading in every array.

    Keys: ``parameter_names``; ``belief_mean`` (12), ``belief_cov`` (12, 12), ``belief_sd`` (12) and ``truth`` (12),
    natural logs; ``information_claimed`` and ``information_true`` (log score, of which the mean over patients counts),
    nats since the prior; ``information_bound`` and ``bound_sd`` (12) only ``with_bound``; ``nees``;
    ``cost`` and ``cost_<limit>`` (mean over the step); ``comfort`` {limit: largest used fraction of the soft limit
    during the step}; ``violation``; ``governor`` (share of the step in which it acted);
    ``left_out`` (share of the step's readings that were missing or frozen, and not used); ``gated`` (share of the
    step's ticks whose readings the filter's gate has refused to learn from);
    ``jaw_state`` (10: true q, u); ``time`` (s).
    """
    covariance = worlds["belief"]["cov"].copy()
    fractions, costs = worlds["fractions"].copy(), worlds["costs"].copy()
    prior, score = worlds["log_det_prior"], worlds["log_score"]
    info = {
        "parameter_names": parameter_names,
        "belief_mean": worlds["belief"]["mean"].copy(),
        "belief_cov": covariance,
        "belief_sd": np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1)),
        "truth": worlds["log_parameters"].copy(),
        "information_claimed": 0.5 * (prior - worlds["log_det"]),
        "information_true": score - worlds["log_score_prior"],
        "nees": worlds["nees"] + 0.0,
        "cost": costs.sum(axis=-1),
        "comfort": {name: fractions[..., i] for i, name in enumerate(COMFORT_LIMITS)},
        "violation": worlds["violated"] != 0,
        "governor": worlds["governor"] + 0.0,
        "left_out": worlds["left_out"] + 0.0,
        "gated": worlds["gated"] + 0.0,
        "jaw_state": worlds["state"].copy(),
        "time": worlds["tick"] * TICK,
    }
    for i, key in enumerate(_COST_KEYS):
        info[key] = costs[..., i]
    if with_bound:
        parameters = slice(-1 - len(parameter_names), -1)
        info["bound_sd"] = np.sqrt(np.diagonal(worlds["bound"], axis1=-2, axis2=-1)[..., parameters])
        info["information_bound"] = 0.5 * (prior - worlds["log_det_bound"])
    return info


def with_masks(info: dict[str, Any], mask: NDArray[np.bool_]) -> dict[str, Any]:
    """Add Gymnasium's ``_key`` mask for every key of a vector environment's info."""
    return info | {f"_{key}": mask for key in info}
