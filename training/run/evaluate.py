"""How good a policy is on a fixed cohort of patients."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from scipy.stats import binom
from stable_baselines3.common.vec_env.base_vec_env import VecEnv

CONFIDENCE = 0.95
MEDIANS = ("worst_sd", "worst_sd_10s")
"""Figures of which the median over patients counts, since a few stiff patients would rule the mean."""


class Predicts(Protocol):
    """A model of stable-baselines3, or an agent."""

    def predict(
        self,
        observation: Any,
        state: tuple[Any, ...] | None = None,
        episode_start: Any = None,
        deterministic: bool = False,
    ) -> tuple[Any, Any]:
        """Actions (N, n_actions) for observations (N, n_obs), and what to hand to the next call."""
        ...


@dataclass(frozen=True)
class Evaluation:
    """Outcome of one episode per patient: every figure is an array (N,), among them ``return``."""

    figures: dict[str, np.ndarray]

    @property
    def mean_return(self) -> float:
        """Mean over the patients of the undiscounted sum of rewards."""
        return float(self.figures["return"].mean())

    def averages(self) -> dict[str, float]:
        """Mean of every figure over the patients; of `MEDIANS` the median."""
        return {
            name: float(np.median(values) if name in MEDIANS else values.mean())
            for name, values in self.figures.items()
        }

    def intervals(self) -> dict[str, float]:
        """Ends of the 95 % confidence interval of each of `MEDIANS`, as ``worst_sd_low`` and ``worst_sd_high``.

        They are order statistics, so that nothing is assumed about the patients (David & Nagaraja 2003, section 7.1).
        """
        ends: dict[str, float] = {}
        for name in self.figures.keys() & set(MEDIANS):
            values = np.sort(self.figures[name])
            cut = max(int(binom.ppf((1.0 - CONFIDENCE) / 2.0, len(values), 0.5)) - 1, 0)
            ends |= {f"{name}_low": float(values[cut]), f"{name}_high": float(values[-1 - cut])}
        return ends


def evaluate(
    policy: Predicts,
    worlds: VecEnv,
    seed: int,
    deterministic: bool = True,
    stopped: Callable[[], bool] = lambda: False,
) -> Evaluation | None:
    """Play one episode in each of the N worlds, started from seed, seed + 1, ..., seed + N - 1.

    A world that ends early starts another episode, which is not counted.

    Args:
        policy: chooses the actions.
        worlds: N worlds used for nothing else, so that the training's own are left alone.
        seed: of the first world.
        deterministic: whether the policy's most likely actions are taken, or drawn ones.
        stopped: asked at every step; the evaluation is given up when it says True.

    Returns:
        The outcome, or None when it was given up.
    """
    worlds.seed(seed)
    observation = worlds.reset()
    memory, starts = None, np.ones(worlds.num_envs, dtype=bool)
    episodes: list[dict[str, float] | None] = [None] * worlds.num_envs
    unfinished = worlds.num_envs
    while unfinished:
        if stopped():
            return None
        actions, memory = policy.predict(np.asarray(observation), memory, starts, deterministic)
        observation, _, starts, infos = worlds.step(actions)
        for i in np.flatnonzero(starts):
            if episodes[i] is None:
                episodes[i] = infos[i]["episode"]
                unfinished -= 1
    finished = [episode for episode in episodes if episode is not None]
    names = {"r": "return", "l": "length"} | {key: key for key in finished[0] if key not in ("r", "l", "t")}
    return Evaluation({name: np.array([episode[key] for episode in finished]) for key, name in names.items()})
