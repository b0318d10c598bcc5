"""Actions as policies make them, without looking: none, independent noise, and exploration noise that is smooth."""

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType

import numpy as np

from jawenv.playing.agents import Action, Array, BatchAgent, Mask, Observation, State

ACTION_SIZE = 4

Draw = Callable[[np.random.Generator, Array, int, float], Array]
"""Next action from a stream, the last action (4), the number of the step and its length (s)."""


def zero(stream: np.random.Generator, last: Array, step: int, dt: float) -> Array:
    """The action 0 of every motor or channel, the middle of its range."""
    return np.zeros_like(last)


def uniform(stream: np.random.Generator, last: Array, step: int, dt: float) -> Array:
    """Independent and uniform at every step."""
    return np.asarray(stream.uniform(-1.0, 1.0, ACTION_SIZE))


def ornstein_uhlenbeck(sd: float, time_s: float) -> Draw:
    """A stationary Ornstein-Uhlenbeck process of this sd and time constant, as exploration noise is."""

    def draw(stream: np.random.Generator, last: Array, step: int, dt: float) -> Array:
        share = np.exp(-dt / time_s) if step else 0.0
        return np.asarray(share * last + sd * np.sqrt(1.0 - share**2) * stream.standard_normal(ACTION_SIZE))

    return draw


class Excitation(BatchAgent):
    """Actions from a stream of random numbers per world.

    World i draws from its own stream, seeded by `seed + i` as the environment seeds its worlds, so that its actions do
    not depend on how many worlds there are.

    Args:
        name: label in tables.
        draw: the law of the actions; they are clipped to [-1, 1].
        control_hz: control steps per second of the environment.
    """

    def __init__(self, name: str, draw: Draw, control_hz: float = 20.0) -> None:
        self.name = name
        self._draw, self._dt = draw, 1.0 / control_hz
        self._streams: list[np.random.Generator] = []
        self._last, self._step = np.zeros((0, ACTION_SIZE)), 0

    def reset(self, num_envs: int, seed: int | None = None) -> None:
        """Seed one stream per world; without a seed the actions differ from run to run."""
        seeds = [None if seed is None else [seed + world, ACTION_SIZE] for world in range(num_envs)]
        self._streams = [np.random.default_rng(words) for words in seeds]
        self._last, self._step = np.zeros((num_envs, ACTION_SIZE)), 0

    def _answer(
        self, rows: Observation, state: State, starts: Mask | None, deterministic: bool
    ) -> tuple[Action, State]:
        if len(self._streams) != len(rows):
            self.reset(len(rows))
        for world, stream in enumerate(self._streams):
            self._last[world] = self._draw(stream, self._last[world], self._step, self._dt)
        self._step += 1
        return np.clip(self._last, -1.0, 1.0).astype(np.float32), None


BASELINES: Mapping[str, Callable[[float], Excitation]] = MappingProxyType(
    {
        "zero": partial(Excitation, "zero", zero),
        "random": partial(Excitation, "random", uniform),
        "ou_strong": partial(Excitation, "ou_strong", ornstein_uhlenbeck(0.6, 1.0)),
    }
)
"""Each by its name, made for so many control steps per second."""
DESCRIPTIONS: Mapping[str, str] = MappingProxyType(
    {
        "zero": "The action 0, the middle of every range",
        "random": "Uniform random actions, new at every step",
        "ou_strong": "Strong random actions that change smoothly within a second",
    }
)
"""A sentence on each baseline."""
