"""Gymnasium's registry: ids, entry points as strings so that nothing is imported before ``make``."""

from __future__ import annotations

from typing import Any

import gymnasium as gym

# Environment -> the model of ``jawenv.ladder`` that it runs; written out, because that module is heavier than this.
ENVIRONMENTS = {
    "jawenv/JawHinge-v3": "hinge",
    "jawenv/JawSagittal-v3": "sagittal",
    "jawenv/JawSides-v3": "sides",
    "jawenv/Jaw-v3": "jaw",
    "jawenv/JawPortions-v3": "portions",
}


# The jaw as a clinic would have it: known within sds, and disturbed by what lasts. Agents that adapt are judged on it.
IMAGED = {"model": "jaw", "knowledge": "imaged", "device": {"unmodelled_time_s": 0.5}}


def register_environments() -> None:
    """Register jawenv's environments; called by ``import jawenv``."""
    for env_id, model in ENVIRONMENTS.items():
        _register(env_id, {"model": model})
    _register("jawenv/JawImaged-v3", IMAGED)


def _register(env_id: str, arguments: dict[str, Any]) -> None:
    gym.register(
        id=env_id,
        entry_point="jawenv.envs.jaw:JawEnv",
        vector_entry_point="jawenv.envs.vector:JawVectorEnv",
        kwargs=arguments,
    )
