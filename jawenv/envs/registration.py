"""Gymnasium's registry: ids, entry points as strings so that nothing is imported before ``make``."""

from __future__ import annotations

import gymnasium as gym


def register_environments() -> None:
    """Register jawenv's environments; called by ``import jawenv``."""
    gym.register(
        id="jawenv/Jaw-v0",
        entry_point="jawenv.envs.jaw:JawEnv",
        vector_entry_point="jawenv.envs.vector:JawVectorEnv",
    )
