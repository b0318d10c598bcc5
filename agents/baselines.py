"""Baselines that look at nothing."""

import numpy as np

from agents.protocol import Action, Mask, Observation, State

ACTION_SIZE = 4


class RandomPolicy:
    """Independent, uniform actions in [-1, 1] at every step.

    World i draws from its own stream, seeded by `seed + i` as the environment seeds its worlds, so that its actions
    do not depend on how many worlds there are.

    Attributes:
        name: `random`.
    """

    def __init__(self) -> None:
        self.name = "random"
        self._streams: list[np.random.Generator] = []

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """Seed one stream per world; without a seed the actions differ from run to run."""
        if seed is None:
            self._streams = [np.random.default_rng() for _ in range(num_envs)]
        else:
            self._streams = [np.random.default_rng([seed + world, ACTION_SIZE]) for world in range(num_envs)]

    def predict(
        self,
        observation: Observation,
        state: State = None,
        episode_start: Mask | None = None,
        deterministic: bool = True,
    ) -> tuple[Action, State]:
        """See `agents.protocol.Agent.predict`; the observation only says how many worlds there are."""
        observation = np.asarray(observation)
        num_envs = 1 if observation.ndim == 1 else len(observation)
        if len(self._streams) != num_envs:
            self.reset(num_envs)
        action = np.stack([stream.uniform(-1.0, 1.0, ACTION_SIZE) for stream in self._streams])
        return action.astype(np.float32).reshape(*observation.shape[:-1], ACTION_SIZE), None
