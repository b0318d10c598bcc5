"""A limit on discomfort: its price is a Lagrange multiplier that is learned beside the policy.

Dual ascent on the logarithm, as for the multiplier of a constraint that must stay positive (Stooke et al. 2020,
arXiv:2007.03964, has the same with more terms). Transitions in a replay buffer keep the price of their time.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

from training.run.config import ComfortConfig

LARGEST_EXCESS = 2.0
"""Of discomfort over target, less 1, that counts in one update."""


class Multiplier:
    """The price of discomfort, nats per s.

    Attributes:
        value: the price now.
    """

    def __init__(self, config: ComfortConfig) -> None:
        self._config = config
        self.value = config.initial_multiplier

    def update(self, discomfort_s: float) -> None:
        """Dual ascent by the mean discomfort of some episodes, s per 30 s."""
        config = self._config
        excess = min(discomfort_s / config.target_discomfort_s - 1.0, LARGEST_EXCESS)
        self.value = min(self.value * math.exp(config.rate * excess), config.largest_multiplier)


class MultiplierUpdates(BaseCallback):
    """Updates the multiplier after every so many episodes, logs it, and keeps it in the model's checkpoints."""

    def __init__(self, multiplier: Multiplier, episodes: int) -> None:
        super().__init__()
        self._multiplier = multiplier
        self._episodes = episodes
        self._finished: list[float] = []

    def _on_training_start(self) -> None:
        self._keep()

    def _on_step(self) -> bool:
        infos: list[dict[str, Any]] = self.locals["infos"]
        self._finished += [info["episode"]["discomfort_s"] for info in infos if "episode" in info]
        return True

    def _on_rollout_end(self) -> None:
        if len(self._finished) < self._episodes:
            return
        discomfort = float(np.mean(self._finished))
        self._finished.clear()
        self._multiplier.update(discomfort)
        self._keep()
        self.logger.record("comfort/multiplier", self._multiplier.value)
        self.logger.record("comfort/discomfort_s", discomfort)

    def _keep(self) -> None:
        """As a plain attribute it is saved with the model."""
        self.model.comfort_multiplier = self._multiplier.value  # type: ignore[attr-defined]
