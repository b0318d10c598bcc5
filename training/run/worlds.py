"""The worlds of a training, and their seeds."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import VectorEnv

from jawenv.base.errors import InputError
from jawenv.base.seeds import TRAINING
from jawenv.controls import mode_of
from jawenv.playing.policies.controller import ControlledWorlds
from jawenv.playing.policies.following import TargetsLaw
from jawenv.playing.policies.residual import BaseTargets
from jawenv.sb3 import NativeVecEnv, Price
from training.run.config import EnvConfig


def world_seed(seed: int, from_step: int) -> int:
    """Seed of the first training world; a resumed run gets another one, and so new patients."""
    return TRAINING.start + int(np.random.SeedSequence([seed, from_step]).generate_state(1)[0] % 2**30)


def worlds_for(config: EnvConfig, n: int, base: BaseTargets | None = None, price: Price | None = None) -> NativeVecEnv:
    """N worlds as a policy is trained on them, reset in the step that ends an episode.

    Args:
        config: of the environment.
        n: how many.
        base: the maneuver that the policy corrects. Where the device does not follow targets, a law does.
        price: of discomfort, which the rewards are less by.
    """
    import jawenv  # noqa: F401  registers its environments

    kwargs: dict[str, Any] = {"autoreset_mode": "same_step", **config.kwargs}
    try:
        env: VectorEnv = gym.make_vec(config.id, n, vectorization_mode="vector_entry_point", **kwargs)
    except (gym.error.Error, ModuleNotFoundError) as error:
        raise InputError(f"env.id {config.id!r}: {' '.join(str(error).split())}") from error
    except TypeError as error:
        raise InputError(f"env.kwargs {config.kwargs} of {config.id}: {error}") from error
    if base is not None:
        mode = mode_of(config.kwargs)
        if not mode.takes_targets:
            env = ControlledWorlds(env, TargetsLaw(mode.name, kwargs.get("control_hz"), base.decision_hz))
        env = ControlledWorlds(env, base)
    return NativeVecEnv(env, price=price)
