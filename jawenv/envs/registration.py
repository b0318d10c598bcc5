"""Gymnasium's registry: ids, entry points as strings so that nothing is imported before ``make``."""

from __future__ import annotations

import gymnasium as gym

# Environment -> the model of ``jawenv.ladder`` that it runs; written out, because that module is heavier than this.
ENVIRONMENTS = {
    "jawenv/JawHinge-v2": "hinge",
    "jawenv/JawSagittal-v2": "sagittal",
    "jawenv/JawSides-v2": "sides",
    "jawenv/Jaw-v2": "jaw",
    "jawenv/JawPortions-v2": "portions",
    "jawenv/JawBilateral-v2": "bilateral",
}


def register_environments() -> None:
    """Register jawenv's environments; called by ``import jawenv``.

    Version 1 of an id is the same world with ``control="force"`` by default, for what was made with it.
    """
    for env_id, model in ENVIRONMENTS.items():
        for version, defaults in ((env_id, {}), (env_id.replace("-v2", "-v1"), {"control": "force"})):
            gym.register(
                id=version,
                entry_point="jawenv.envs.jaw:JawEnv",
                vector_entry_point="jawenv.envs.vector:JawVectorEnv",
                kwargs={"model": model, **defaults},
            )
