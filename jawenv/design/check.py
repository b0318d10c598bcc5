"""A checker of design environments, in the manner of Gymnasium's checker of environments."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jawenv.base.errors import InputError
from jawenv.inference.settings import Array

_DRAWS, _TRIALS = 16, 4
_SYMMETRIC = 1e-6


def check_design_env(env: Any, *, steps: int = 10, seed: int = 0) -> None:
    """Check that an environment is a design environment, as ``DesignEnv`` describes it.

    It plays two episodes with the same seed, draws from the prior, simulates, and compares likelihoods: on average
    readings are likelier under the parameters that made them than under others of the prior.

    Args:
        env: with ``reset`` and ``step`` of Gymnasium.
        steps: of an episode, 2 or more.
        seed: of everything that is drawn.

    Raises:
        InputError: the first thing that is not as described.
    """
    names = tuple(env.parameter_names)
    _require(bool(names) and len(set(names)) == len(names), "parameter_names", names, "distinct names, one or more")
    theta = _checked_prior(env.prior, len(names), seed)
    actions = _checked_episodes(env, len(names), steps, seed)
    _checked_simulator(env, theta, actions, seed)
    _checked_likelihood(env, theta, actions, seed)


def _require(holds: bool, name: str, found: object, allowed: str) -> None:
    if not holds:
        raise InputError(f"{name} is {found!r}; allowed in a design environment: {allowed}")


def _checked_prior(prior: Any, size: int, seed: int) -> Array:
    """Draws (``_DRAWS``, p) of the prior."""
    theta = np.asarray(prior.sample(_DRAWS, seed), dtype=np.float64)
    _require(theta.shape == (_DRAWS, size), "shape of prior.sample(n, seed)", theta.shape, "(n, p)")
    _require(bool(np.isfinite(theta).all()), "prior.sample", "not finite", "finite parameters")
    again = np.array_equal(theta, prior.sample(_DRAWS, seed))
    other = np.array_equal(theta, prior.sample(_DRAWS, seed + 1))
    _require(again and not other, "prior.sample", "not of its seed", "the same draws for the same seed, others else")
    density = np.asarray(prior.log_density(theta))
    _require(density.shape == (_DRAWS,), "shape of prior.log_density(theta)", density.shape, "(n,)")
    _require(bool(np.isfinite(density).all()), "prior.log_density", "not finite", "finite at draws of the prior")
    return theta


def _checked_episodes(env: Any, size: int, steps: int, seed: int) -> Array:
    """The actions (K, ...) of an episode."""
    played = [_episode(env, size, steps, seed) for _ in range(2)]
    alike = all(np.array_equal(one, other) for one, other in zip(played[0], played[1], strict=True))
    _require(alike, "an episode", "another one under the same seed", "the same for the same seed and actions")
    truth = played[0][1]
    density = float(np.asarray(env.prior.log_density(truth[None]))[0])
    _require(np.isfinite(density), "log density of info['truth'] in the prior", density, "finite: reset draws from it")
    return played[0][0]


def _episode(env: Any, size: int, steps: int, seed: int) -> tuple[Array, Array, Array]:
    """Actions (K, ...), truth (p,) and the last belief's mean (p,) of an episode."""
    env.action_space.seed(seed)
    actions: list[Array] = []
    _, info = env.reset(seed=seed)
    ended = False
    while True:
        mean, truth = _checked_info(info, size)
        if ended or len(actions) == steps:
            return np.array(actions), truth, mean
        actions.append(np.asarray(env.action_space.sample()))
        *_, terminated, truncated, info = env.step(actions[-1])
        ended = bool(terminated or truncated)


def _checked_info(info: dict[str, Any], size: int) -> tuple[Array, Array]:
    """The belief's mean (p,) and the truth (p,)."""
    for name in ("belief_mean", "belief_cov", "truth", "cost"):
        _require(name in info, f"info[{name!r}]", "missing", "after reset and after each step")
    mean, cov, truth = (np.asarray(info[name], dtype=np.float64) for name in ("belief_mean", "belief_cov", "truth"))
    shapes = mean.shape, cov.shape, truth.shape
    _require(shapes == ((size,), (size, size), (size,)), "shapes of belief and truth", shapes, "(p,), (p, p), (p,)")
    scale = np.sqrt(np.abs(np.diagonal(cov)))
    symmetric = np.allclose(cov, cov.T, atol=_SYMMETRIC * float(scale.max()) ** 2)
    positive = symmetric and float(np.linalg.eigvalsh(cov / np.outer(scale, scale))[0]) > 0.0
    _require(positive, "info['belief_cov']", "no covariance", "symmetric, positive definite")
    _require(bool(np.isfinite(mean).all()), "info['belief_mean']", mean, "finite numbers")
    cost = float(info["cost"])
    _require(cost >= 0.0, "info['cost']", cost, "0 or more")
    return mean, truth


def _checked_simulator(env: Any, theta: Array, actions: Array, seed: int) -> None:
    first, again, other = (_arrays(env.simulate(theta[0], actions, number)) for number in (seed, seed, seed + 1))
    _require(bool(first), "simulate(theta, actions, seed)", "without arrays", "a mapping of names to arrays")
    alike = all(np.array_equal(first[name], again[name], equal_nan=True) for name in first)
    _require(alike, "simulate", "another reading under the same seed", "the same for the same seed")
    apart = any(not np.array_equal(first[name], other[name], equal_nan=True) for name in first)
    _require(apart, "simulate", "the same reading under another seed", "noise of its seed")


def _arrays(readings: Mapping[str, Any]) -> dict[str, Array]:
    return {name: value for name, value in readings.items() if isinstance(value, np.ndarray)}


def _checked_likelihood(env: Any, theta: Array, actions: Array, seed: int) -> None:
    gains = []
    for trial in range(_TRIALS):
        values = env.log_likelihood(env.simulate(theta[trial], actions, seed + trial), theta)
        if values is None:
            return
        values = np.asarray(values, dtype=np.float64)
        _require(values.shape == (_DRAWS,), "shape of log_likelihood(readings, theta)", values.shape, "(m,)")
        _require(bool(np.isfinite(values[trial])), "log_likelihood", values[trial], "finite at the truth")
        gains.append(values[trial] - np.delete(values, trial).mean())
    found = float(np.mean(gains))
    _require(found > 0.0, "log_likelihood of the truth less that of others", round(found, 3), "above 0 on average")
