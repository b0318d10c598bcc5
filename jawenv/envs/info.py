"""The info dictionary: belief, truth, discomfort and information of one world or of N."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.device.comfort import COMFORT_LIMITS
from jawenv.device.device import TICK
from jawenv.filter.settled import settled

_COST_KEYS = tuple(f"cost_{name}" for name in COMFORT_LIMITS)
_COMFORT_KEYS = tuple(f"comfort_{name}" for name in COMFORT_LIMITS)


class WorldReader:
    """Reads infos out of worlds, through views of their fields that are made once.

    Keys: ``belief_mean`` (12), ``belief_cov`` (12, 12), ``belief_sd`` (12) and ``truth`` (12), natural logs;
    ``information_claimed`` and ``information_true`` (log score, of which the mean over patients counts), nats since the
    prior; ``information_bound`` and ``bound_sd`` (12) only with the bound; ``nees``; ``cost`` and ``cost_<limit>``
    (mean over the step); ``comfort_<limit>`` (largest used fraction of the soft limit during the step); ``violation``;
    ``governor`` (share of the step in which it acted); ``left_out`` (share of the step's readings that were missing or
    frozen, and not used); ``gated`` (share of the step's ticks whose readings the filter's gate has refused to learn
    from); ``misfit`` (the alarm: above 1 no parameters explain what was read, or the belief moves by more than it
    claims, see ``filter.alarm.misfit``); ``learnt_s`` (s of readings that teach something, off the teeth); ``settled``
    (bool: the belief may be acted on, see ``filter.settled``); ``jaw_state`` (10: true q, u); ``time`` (s);
    ``episode_key`` (2, int64: of the episode's patient and random numbers, with which ``reset`` begins it again);
    ``asked`` (6, bool: which muscles are asked for; only with the argument ``asked``); ``spent`` (share of the budget
    of discomfort, as the device takes it to be; only with ``comfort_budget_s``).

    A light info has ``belief_mean``, ``belief_sd``, ``truth``, ``cost``, ``violation``, ``misfit``, ``time``,
    ``episode_key``, ``asked``, ``spent`` and the bound's keys alone.

    Args:
        worlds: (N,) records of dtype ``world_dtype``; the array must stay the simulation's own.
        keys: (N, 2) of the episodes; likewise.
        with_bound: whether the bound is computed.
        light: whether the info is light.
        asked: (N, M) of the muscles, likewise; None where all are.
        budget: whether a budget of discomfort is kept.
        own: whether beliefs are those of estimators of the user's, which count as settled.
    """

    def __init__(
        self,
        worlds: NDArray[np.void],
        keys: NDArray[np.uint64],
        with_bound: bool,
        light: bool = False,
        asked: NDArray[np.bool_] | None = None,
        budget: bool = False,
        own: bool = False,
    ) -> None:
        """Make the views."""
        self._arguments = worlds, keys, with_bound, light, asked, budget, own
        self._asked, self._own = asked, own
        self._budget = worlds["known"]["tracker"]["budget"] if budget else None
        self._keys, self._bounded, self._light = keys, with_bound, light
        truth, known = worlds["truth"], worlds["known"]
        self._mean, self._covariance = known["belief"]["mean"], known["belief"]["cov"]
        self._truth, self._state = truth["log_parameters"], truth["state"]
        self._fractions, self._costs = truth["fractions"], truth["costs"]
        self._prior, self._log_det = known["log_det_prior"], known["log_det"]
        self._log_det_bound = truth["log_det_bound"]
        self._score_prior, self._score, self._nees = truth["log_score_prior"], truth["log_score"], truth["nees"]
        self._violated, self._governor = truth["violated"], truth["governor"]
        self._tick, self._left_out, self._gated = known["tick"], known["left_out"], known["gated"]
        self._misfit, self._readings = known["belief"]["misfit"], known["belief"]["readings"]
        self._replayed_at = known["belief"]["replayed_at"]
        first_parameter = -1 - self._mean.shape[1]
        self._bound_variance = np.diagonal(truth["bound"], axis1=1, axis2=2)[:, first_parameter:-1]
        self._variance = np.diagonal(self._covariance, axis1=1, axis2=2)
        self._first = tuple(
            field[0] for field in (self._mean, self._covariance, self._variance, self._truth, self._state, self._costs)
        )

    def __reduce__(self) -> Any:
        """A copy reads the copied worlds: copies of views would be arrays of their own."""
        return WorldReader, self._arguments

    def first(self) -> dict[str, Any]:
        """Fresh info of the first world; its scalars are Python's."""
        mean, covariance, variance, truth, state, costs = self._first
        prior = self._prior.item(0)
        info = {
            "belief_mean": mean.copy(),
            "belief_sd": np.sqrt(variance),
            "truth": truth.copy(),
            "cost": float(np.add.reduce(costs)),
            "violation": self._violated.item(0) != 0,
            "misfit": self._misfit.item(0),
            "time": self._tick.item(0) * TICK,
            "episode_key": self._keys[0].astype(np.int64),
        }
        if self._asked is not None:
            info["asked"] = self._asked[0].copy()
        if self._budget is not None:
            info["spent"] = self._budget["spent"].item(0) / self._budget["total"].item(0)
        if self._bounded:
            info["bound_sd"] = np.sqrt(self._bound_variance[0])
            info["information_bound"] = 0.5 * (prior - self._log_det_bound.item(0))
        if self._light:
            return info
        info |= {
            "belief_cov": covariance.copy(),
            "information_claimed": 0.5 * (prior - self._log_det.item(0)),
            "information_true": self._score.item(0) - self._score_prior.item(0),
            "nees": self._nees.item(0),
            "governor": self._governor.item(0),
            "left_out": self._left_out.item(0),
            "gated": self._gated.item(0),
            "learnt_s": self._readings.item(0) * TICK,
            "settled": bool(self._settled(slice(0, 1))[0]),
            "jaw_state": state.copy(),
        }
        info.update(zip(_COST_KEYS, costs.tolist(), strict=True))
        info.update(zip(_COMFORT_KEYS, self._fractions[0].tolist(), strict=True))
        return info

    def all(self) -> dict[str, Any]:
        """Fresh info of all worlds: the keys of ``first``, with N leading in every array."""
        info = {
            "belief_mean": self._mean.copy(),
            "belief_sd": np.sqrt(self._variance),
            "truth": self._truth.copy(),
            "cost": self._costs.sum(axis=1),
            "violation": self._violated != 0,
            "misfit": self._misfit.copy(),
            "time": self._tick * TICK,
            "episode_key": self._keys.astype(np.int64),
        }
        if self._asked is not None:
            info["asked"] = self._asked.copy()
        if self._budget is not None:
            info["spent"] = self._budget["spent"] / self._budget["total"]
        if self._bounded:
            info["bound_sd"] = np.sqrt(self._bound_variance)
            info["information_bound"] = 0.5 * (self._prior - self._log_det_bound)
        if self._light:
            return info
        info |= {
            "belief_cov": self._covariance.copy(),
            "information_claimed": 0.5 * (self._prior - self._log_det),
            "information_true": self._score - self._score_prior,
            "nees": self._nees.copy(),
            "governor": self._governor.copy(),
            "left_out": self._left_out.copy(),
            "gated": self._gated.copy(),
            "learnt_s": self._readings * TICK,
            "settled": self._settled(slice(None)),
            "jaw_state": self._state.copy(),
        }
        info.update(zip(_COST_KEYS, self._costs.T.copy(), strict=True))
        info.update(zip(_COMFORT_KEYS, self._fractions.T.copy(), strict=True))
        return info

    def _settled(self, rows: slice) -> NDArray[np.bool_]:
        """Whether the beliefs of some worlds are settled."""
        if self._own:
            return np.ones(len(self._readings[rows]), dtype=np.bool_)
        mean, at, variance = self._mean[rows], self._replayed_at[rows], self._variance[rows]
        return settled(mean - at, np.sqrt(variance), self._readings[rows] * TICK)


def with_masks(info: dict[str, Any], mask: NDArray[np.bool_]) -> dict[str, Any]:
    """Add Gymnasium's ``_key`` mask for every key of a vector environment's info."""
    return info | {f"_{key}": mask for key in info}
