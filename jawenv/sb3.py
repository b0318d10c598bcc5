"""A native vector environment as the `VecEnv` of stable-baselines3: `NativeVecEnv` (extra `sb3`).

Both step all worlds with one call, so the adapter only translates the end of an episode. stable-baselines3
needs the last observation of the old episode and the first of the new one in the same step: that is
Gymnasium's autoreset mode ``same_step``, the only one accepted here.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any, Protocol

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, VectorEnv

from jawenv.base.errors import InputError
from jawenv.base.extras import needs

with needs("jawenv.sb3", "stable_baselines3", extra="sb3"):
    from stable_baselines3.common.vec_env.base_vec_env import VecEnv, VecEnvIndices, VecEnvObs, VecEnvStepReturn

EPISODE_FIGURES = ("information_claimed", "information_true", "violation")
"""Keys of ``final_info`` that are copied into the ``episode`` record of a finished world, where present."""
DISCOMFORT_PER_S = 30.0
"""Discomfort is the integral of the cost over so many seconds."""
EARLY_S = 10.0
"""When the worst sd is noted for the first time; the second is the end of the episode."""
KNOWN = 0.05
"""Worst sd at which all parameters count as known."""


class Price(Protocol):
    """Price of a second of discomfort now, nats."""

    value: float


class NativeVecEnv(VecEnv):
    """Steps a native vector environment of N worlds on behalf of stable-baselines3.

    ``NativeVecEnv("jawenv/Jaw-v3", 64, cohort="one_sided")``

    ``infos[i]`` is empty while world i's episode goes on. At its end it holds ``terminal_observation``,
    ``TimeLimit.truncated`` and ``episode``: return ``r``, length ``l``, seconds ``t`` since the adapter was
    made, the `EPISODE_FIGURES` of the last step, ``cost``, the sum of ``info["cost"]`` over the episode's
    steps (safety-gymnasium's episode cost), and ``discomfort_s``, what that is for 30 s. Where the environment tells
    time and sds, there is the largest sd that is asked for at the end (``worst_sd``) and `EARLY_S` after the start, or
    at the end of a shorter episode (``worst_sd_10s``), and the seconds until a settled belief is at `KNOWN`, infinite
    if none was (``known_s``). The same figures, and the other numbers of ``final_info``, stand beside ``episode``,
    where ``VecMonitor(worlds, info_keywords=("cost",))`` finds them.

    Attributes:
        discomfort_s: (N,) cost of the latest step times its length, s; 0 where the environment tells no cost or time.

    Args:
        env: an id that ``gym.make_vec`` knows, or a vector environment whose metadata says ``autoreset_mode``
            same_step; seeded with s, world i must start from s + i.
        num_envs: of an id; a vector environment has its own.
        price: of discomfort: each reward is less by price times discomfort of the step. None by default.
        arguments: of an id, for ``gym.make_vec``.
    """

    def __init__(
        self,
        env: str | VectorEnv[Any, Any, Any],
        num_envs: int | None = None,
        *,
        price: Price | None = None,
        **arguments: Any,
    ) -> None:
        if isinstance(env, str):
            env = gym.make_vec(env, num_envs=num_envs or 1, **{"autoreset_mode": "same_step", **arguments})
        elif num_envs is not None or arguments:
            given = ["num_envs", *arguments][num_envs is None]
            raise InputError(f"{given} stands beside a vector environment; allowed: beside an id, as 'jawenv/Jaw-v3'")
        mode = env.metadata.get("autoreset_mode")
        if mode != AutoresetMode.SAME_STEP:
            actual = mode.name.lower() if isinstance(mode, AutoresetMode) else mode
            line = f'NativeVecEnv("{_name(env)}", {env.num_envs})'
            raise InputError(
                f"autoreset_mode of {_name(env)} is {actual!r}; allowed: 'same_step' of gym.make_vec(..., "
                f'autoreset_mode="same_step"), as {line} makes it'
            )
        if not isinstance(env.single_observation_space, spaces.Box):
            space = str(env.single_observation_space)
            raise InputError(f"{_name(env)}'s observation space is {space}, but NativeVecEnv needs a Box")
        self.env, self._price = env, price
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)
        self._actions: np.ndarray | None = None
        self._start = time.monotonic()
        self._clear()

    def _clear(self) -> None:
        self._returns = np.zeros(self.num_envs)
        self._costs = np.zeros(self.num_envs)
        self._early_sd, self._known_s = (np.full(self.num_envs, value) for value in (np.nan, np.inf))
        self.discomfort_s = np.zeros(self.num_envs)
        self._lengths = np.zeros(self.num_envs, dtype=np.int64)

    def reset(self) -> VecEnvObs:
        """Start new episodes in all worlds, the first time after `seed` with that seed.

        Returns:
            Observations (N, n_obs).
        """
        observation, _ = self.env.reset(seed=self._seeds[0], options=self._options[0] or None)
        self._reset_seeds()
        self._reset_options()
        self._clear()
        return np.asarray(observation)

    def step_async(self, actions: np.ndarray) -> None:
        """Keep the actions (N, n_actions) for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Step all worlds. Returns observations (N, n_obs), rewards (N,), dones (N,) and N infos."""
        observation, reward, terminated, truncated, info = self.env.step(self._actions)
        self._returns += reward
        self._lengths += 1
        if "cost" in info:
            self._costs += info["cost"]
        done = np.logical_or(terminated, truncated)
        self._note_step(info, done)
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        if done.any():
            self._finish(np.flatnonzero(done), terminated, info, infos)
        paid = self._checked(reward)
        if self._price is not None:
            paid = (paid - self._price.value * self.discomfort_s).astype(np.float32)
        return np.asarray(observation), paid, done, infos

    def _note_step(self, info: dict[str, Any], done: np.ndarray) -> None:
        """Discomfort of the step, the worst sd of worlds that are `EARLY_S` old, and when a world became known."""
        time_s = _last(info, "time", done)
        if time_s is None:
            return
        cost, sd = _last(info, "cost", done), _last(info, "belief_sd", done)
        asked = _last(info, "asked", done)
        if cost is not None:
            self.discomfort_s = cost * time_s / self._lengths
        if sd is not None:
            worst = (sd if asked is None else sd * np.repeat(asked, 2, axis=1)).max(axis=1)
            early = np.isnan(self._early_sd) & ((time_s >= EARLY_S - 1e-9) | done)
            self._early_sd[early] = worst[early]
            settled = _last(info, "settled", done)
            sure = (worst <= KNOWN) & (True if settled is None else settled > 0.0)
            known = np.isinf(self._known_s) & sure
            self._known_s[known] = time_s[known]

    def _checked(self, reward: np.ndarray) -> np.ndarray:
        """Rewards (N,) in single precision, all finite: any other number would silently ruin the whole network."""
        with np.errstate(over="ignore"):
            single = np.asarray(reward, dtype=np.float32)
        if not np.isfinite(single).all():
            i = int(np.flatnonzero(~np.isfinite(single))[0])
            raise InputError(f"reward of world {i} of {_name(self.env)} is {reward[i]}; allowed: a finite number")
        return single

    def _finish(
        self, worlds: np.ndarray, terminated: np.ndarray, info: dict[str, Any], infos: list[dict[str, Any]]
    ) -> None:
        """Fill in the infos of the worlds whose episode ended with this step and clear their sums."""
        final_info = info.get("final_info", {})
        figures = [key for key in EPISODE_FIGURES if key in final_info]
        if "cost" in info and "cost" in final_info:
            # info["cost"] of a finished world already belongs to its next episode.
            self._costs[worlds] += np.asarray(final_info["cost"])[worlds] - np.asarray(info["cost"])[worlds]
        elapsed_s = round(time.monotonic() - self._start, 6)
        for i in worlds.tolist():
            episode = {"r": float(self._returns[i]), "l": int(self._lengths[i]), "t": elapsed_s}
            episode.update({key: float(final_info[key][i]) for key in figures})
            if "cost" in info:
                episode["cost"] = float(self._costs[i])
                episode["discomfort_s"] = DISCOMFORT_PER_S * float(self._costs[i] / self._lengths[i])
            if "time" in final_info and "belief_sd" in final_info:
                asked = np.repeat(final_info["asked"][i], 2) if "asked" in final_info else True
                episode["worst_sd"] = float(np.max(final_info["belief_sd"][i] * asked))
                episode["worst_sd_10s"], episode["known_s"] = float(self._early_sd[i]), float(self._known_s[i])
            numbers = {key: float(values[i]) for key, values in final_info.items() if np.ndim(values) == 1}
            infos[i] = {
                **numbers,
                **{key: value for key, value in episode.items() if key not in ("r", "l", "t")},
                "terminal_observation": np.asarray(info["final_obs"][i]),
                "TimeLimit.truncated": not terminated[i],
                "episode": episode,
            }
        self._returns[worlds] = 0.0
        self._costs[worlds] = 0.0
        self._early_sd[worlds], self._known_s[worlds] = np.nan, np.inf
        self._lengths[worlds] = 0

    def close(self) -> None:
        """Close the environment; closing twice is harmless."""
        if not self.env.closed:
            self.env.close()

    def get_images(self) -> Sequence[np.ndarray | None]:
        """A frame (height, width, 3) of each world, as the environment's ``render_mode`` says; None without one."""
        frames: Any = self.env.render() if self.render_mode else None
        return list(frames or [None] * self.num_envs)

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """The attribute of the vector environment, once for each world asked for: the worlds share it."""
        return [getattr(self.env, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Refused: the worlds are rows of arrays and have no attributes of their own."""
        raise InputError(f"cannot set {attr_name!r} of single worlds of the native {_name(self.env)}")

    def env_method(
        self, method_name: str, *method_args: Any, indices: VecEnvIndices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Refused: the worlds are rows of arrays and have no methods of their own."""
        raise InputError(f"cannot call {method_name!r} of single worlds of the native {_name(self.env)}")

    def env_is_wrapped(self, wrapper_class: type[Any], indices: VecEnvIndices = None) -> list[bool]:
        """No world is wrapped by a single-environment wrapper."""
        return [False] * len(list(self._get_indices(indices)))


def _last(info: dict[str, Any], key: str, done: np.ndarray) -> np.ndarray | None:
    """Infos (N, ...) of the last step, also of worlds that it ended; None where the environment has none."""
    if key not in info:
        return None
    values = np.array(info[key], dtype=np.float64)
    final = info.get("final_info", {})
    if done.any() and key in final:
        values[done] = np.asarray(final[key])[done]
    return values


def _name(env: VectorEnv[Any, Any, Any]) -> str:
    return env.spec.id if env.spec is not None else type(env).__name__
