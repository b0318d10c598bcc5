"""How good a policy is on a fixed cohort of patients."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from training.vec_env import NativeVecEnv

Act = Callable[[np.ndarray], np.ndarray]
"""Observations (N, n_obs) to actions (N, n_actions)."""


@dataclass(frozen=True)
class Evaluation:
    """Outcome of one episode per patient: every figure is an array (N,), among them ``return``."""

    figures: dict[str, np.ndarray]

    @property
    def mean_return(self) -> float:
        """Mean over the patients of the undiscounted sum of rewards."""
        return float(self.figures["return"].mean())

    def means(self) -> dict[str, float]:
        """Mean of every figure over the patients."""
        return {name: float(values.mean()) for name, values in self.figures.items()}


def evaluate(
    act: Act, worlds: NativeVecEnv, seed: int, stopped: Callable[[], bool] = lambda: False
) -> Evaluation | None:
    """Play one episode in each of the N worlds, started from seed, seed + 1, ..., seed + N - 1.

    A world that ends early starts another episode, which is not counted.

    Args:
        act: the policy.
        worlds: N worlds used for nothing else, so that the training's own are left alone.
        seed: of the first world.
        stopped: asked at every step; the evaluation is given up when it says True.

    Returns:
        The outcome, or None when it was given up.
    """
    worlds.seed(seed)
    observation = worlds.reset()
    episodes: list[dict[str, float] | None] = [None] * worlds.num_envs
    unfinished = worlds.num_envs
    while unfinished:
        if stopped():
            return None
        observation, _, done, infos = worlds.step(act(np.asarray(observation)))
        for i in np.flatnonzero(done):
            if episodes[i] is None:
                episodes[i] = infos[i]["episode"]
                unfinished -= 1
    finished = [episode for episode in episodes if episode is not None]
    names = {"r": "return", "l": "length"} | {key: key for key in finished[0] if key not in ("r", "l", "t")}
    return Evaluation({name: np.array([episode[key] for episode in finished]) for key, name in names.items()})
