"""Gymnasium's registry: ids, entry points as strings so that nothing is imported before ``make``."""

from __future__ import annotations

import gymnasium as gym

# Environment -> the model of ``jawenv.ladder`` that it runs; written out, because that module is heavier than this.
ENVIRONMENTS = {
    "jawenv/JawHinge-v1": "hinge",
    "jawenv/JawSagittal-v1": "sagittal",
    "jawenv/JawSides-v1": "sides",
    "jawenv/Jaw-v1": "jaw",
    "jawenv/JawPortions-v1": "portions",
    "jawenv/JawBilateral-v1": "bilateral",
}


def register_environments() -> None:
    """Register jawenv's environments; called by ``import jawenv``."""
    for env_id, model in ENVIRONMENTS.items():
        gym.register(
            id=env_id,
            entry_point="jawenv.envs.jaw:JawEnv",
            vector_entry_point="jawenv.envs.vector:JawVectorEnv",
            kwargs={"model": model},
        )
