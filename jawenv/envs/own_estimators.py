"""Estimators of the user's in the place of the device's filter: the belief that observation, info and reward show.

The device's filter goes on beside it: its motion is what the observation's pose and the law of targets control have.
Between two steps the worlds' records hold the own belief; while a step is computed, they hold that of the device.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from jawenv.anatomy import Prior
from jawenv.base.errors import InputError, shown
from jawenv.device.device import TICK
from jawenv.envs.world.belief_kernel import show_beliefs
from jawenv.envs.world.step_kernel import Shared
from jawenv.mechanics.dynamics import N_WRENCH

Array = NDArray[np.float64]
ASYMMETRY = 1e-6  # of a covariance that rounding explains, relative to its largest entry

__all__ = ["EpisodeStart", "OwnEstimator", "OwnEstimators"]


@dataclass(frozen=True, eq=False)
class EpisodeStart:
    """The start of an episode, before the first reading; names and units are those of a ``Record``."""

    parameter_names: tuple[str, ...]  # p names, as ``log_F_o/masseter_left``
    prior: Prior  # belief about the p natural-log parameters
    jaw: Any  # geometry and mass as the filter believes them, a record of dtype ``jaw_dtype``
    start_mean: Array  # (n,) believed motion (q, u)
    start_sd: Array  # (n,) its sd; 0 for a coordinate that cannot move
    tick_s: float  # s from one update to the next
    ticks_per_step: int  # updates in a step; observation and reward read the belief after the last of them
    measurement_sd: Array  # (12,) noise of the encoders
    wrench_sd: Array
    """(6,) sd of the wrench not known, anew in each tick: what no model explains, and the noise of the mean of a
    tick's load-cell samples.
    """
    cell_sd: Array  # (6,) sd of the latter alone
    gain_sd: float  # sd of the load cell's relative gain error, one value for the episode


@runtime_checkable
class OwnEstimator(Protocol):
    """Protocol of an object that can be the ``estimator`` of an environment.

    ``belief`` is an attribute or a property: mean (p,) and covariance (p, p) of the natural-log parameters.
    """

    @property
    def belief(self) -> tuple[Any, Any]:
        """Mean (p,) and covariance (p, p) after the last update."""

    def reset(self, start: EpisodeStart) -> Any:
        """Begin an episode: forget all readings."""

    def update(self, measured: Array, samples: Array | None) -> Any:
        """Take the readings of one tick.

        Args:
            measured: (12,) encoders at the tick's end: mouthpiece position (m, head axes), Euler angles theta, psi,
                alpha (rad), mouthpiece velocity (m/s), angular velocity (rad/s, body axes); NaN where not read.
            samples: (3, 6) load cell at start, middle and end of the tick: force (N) and moment (N m) of the device on
                the mouthpiece, body axes; NaN where not read. None at the first update, before anything has moved.
        """


class OwnEstimators:
    """An own estimator for each of N worlds: copies of one that is given.

    Args:
        estimator: which is copied.
        simulation: the N worlds, of a ``Simulation``; their records take the beliefs.
    """

    def __init__(self, estimator: Any, simulation: Any) -> None:
        """Make the copies."""
        self._simulation = simulation
        number, parameters = len(simulation.worlds), len(simulation.parameter_names)
        self.each = [copy.deepcopy(estimator) for _ in range(number)]
        """(N,) the estimators."""
        self._means = np.zeros((number, parameters))
        self._covs = np.zeros((number, parameters, parameters))
        self._failed = np.zeros(number, dtype=np.bool_)

    def before_step(self, active: NDArray[np.bool_]) -> None:
        """The active worlds' records hold the belief of the device's filter again.

        Raises:
            ResetNeeded: the estimator of one of them has failed since its reset.
        """
        if (self._failed & active).any():
            raise ResetNeeded("the estimator has failed in this episode; call reset() before step()")
        belief = self._simulation.worlds["known"]["belief"]
        belief["mean"][active], belief["cov"][active] = self._means[active], self._covs[active]

    def begin(self, chosen: NDArray[np.bool_]) -> None:
        """Reset the estimators of the chosen worlds (N,), whose sensors have been read for the first time."""
        numbers, ticks = np.flatnonzero(chosen).tolist(), self._simulation.ticks
        starts = [self._episode_start(i) for i in numbers]
        self._failed |= chosen
        for i, start in zip(numbers, starts, strict=True):
            self.each[i].reset(start)
            self.each[i].update(ticks["measured"][i, 0].astype(float), None)
        self._take(chosen)
        self._failed &= ~chosen

    def after_step(self, active: NDArray[np.bool_]) -> None:
        """Give the active worlds' readings of a step to their estimators, and the beliefs to their records."""
        worlds, ticks = self._simulation.worlds, self._simulation.ticks
        ticks_per_step = self._simulation.configuration.ticks_per_step
        self._failed |= active
        for i in np.flatnonzero(active).tolist():
            last = int(worlds["known"]["tick"][i])
            for row in ticks[i, last - ticks_per_step + 1 : last + 1]:
                self.each[i].update(row["measured"].astype(float), row["samples"].astype(float))
        self._take(active)
        self._failed &= ~active

    def _take(self, chosen: NDArray[np.bool_]) -> None:
        """Information and observation of the chosen worlds by the beliefs of their own estimators."""
        simulation = self._simulation
        belief, numbers = simulation.worlds["known"]["belief"], np.flatnonzero(chosen)
        own = [_checked_belief(self.each[i], self._means.shape[1]) for i in numbers.tolist()]
        self._means[numbers], self._covs[numbers] = belief["mean"][numbers], belief["cov"][numbers]
        for i, (mean, cov) in zip(numbers.tolist(), own, strict=True):
            belief["mean"][i], belief["cov"][i] = mean, cov
        shared = Shared(simulation.device, simulation.settings, simulation.scratches)
        show_beliefs(shared, simulation.models, simulation.worlds, chosen, simulation.observation)

    def _episode_start(self, index: int) -> EpisodeStart:
        """The start of an episode for the estimator of world ``index``."""
        simulation = self._simulation
        settings, noise = simulation.settings["filter"][0], simulation.settings["noise_variance"][0]
        began = simulation.worlds["known"]["belief"]["began"][index]
        return EpisodeStart(
            parameter_names=simulation.parameter_names,
            prior=simulation.cohort.prior,
            jaw=simulation.models[index].copy(),
            start_mean=began.copy(),
            start_sd=settings["start_sd"][: len(began)].copy(),
            tick_s=TICK,
            ticks_per_step=simulation.configuration.ticks_per_step,
            measurement_sd=np.sqrt(settings["measurement_variance"]),
            wrench_sd=np.sqrt(noise[:N_WRENCH]),
            cell_sd=np.sqrt(noise[N_WRENCH:]),
            gain_sd=float(simulation.device[0]["cell_gain"]),
        )


def _checked_belief(estimator: Any, parameters: int) -> tuple[Array, Array]:
    """Mean (p,) and covariance (p, p) of an estimator."""
    name, allowed = type(estimator).__name__, f"mean ({parameters},) and covariance ({parameters}, {parameters})"
    value = getattr(estimator, "belief", None)
    try:
        mean, cov = (np.asarray(part, dtype=np.float64) for part in value)  # type: ignore[union-attr]
    except (TypeError, ValueError):
        raise InputError(f"estimator {name}: belief is {shown(value)}; allowed: {allowed}") from None
    if mean.shape != (parameters,) or cov.shape != (parameters, parameters):
        raise InputError(f"estimator {name}: belief has shapes {mean.shape} and {cov.shape}; allowed: {allowed}")
    if not (np.isfinite(mean).all() and np.isfinite(cov).all()):
        raise InputError(f"estimator {name}: belief holds a number that is not finite; allowed: finite numbers")
    if np.abs(cov - cov.T).max() > ASYMMETRY * np.abs(cov).max():
        raise InputError(f"estimator {name}: the belief's covariance is not symmetric; allowed: a symmetric one")
    return mean, cov
