"""Actions as policies make them, without looking: noise that is smooth, harmonics, and switching between extremes.

A filter has to stay honest under whatever an agent does. These are the actions that it is tested with beside the
maneuvers: exploration noise of learning algorithms, and the most hostile that an action space allows.
"""

from collections.abc import Callable, Mapping
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


def _ornstein_uhlenbeck(sd: float, time_s: float) -> Draw:
    """A stationary Ornstein-Uhlenbeck process of this sd and time constant, as exploration noise is."""

    def draw(stream: np.random.Generator, last: Array, step: int, dt: float) -> Array:
        share = np.exp(-dt / time_s) if step else 0.0
        return np.asarray(share * last + sd * np.sqrt(1.0 - share**2) * stream.standard_normal(ACTION_SIZE))

    return draw


def switching(mean_s: float) -> Draw:
    """Each motor at 1 or -1, thrown over after times with this mean."""

    def draw(stream: np.random.Generator, last: Array, step: int, dt: float) -> Array:
        drawn = stream.choice([-1.0, 1.0], ACTION_SIZE)
        thrown = stream.random(ACTION_SIZE) < 1.0 - np.exp(-dt / mean_s)
        return np.where(thrown | (step == 0), drawn, last)

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


class RandomHarmonics(Excitation):
    """Four sines in each motor, of random amplitudes that add up to at most 1, random phases, and 0.1 to 2 Hz."""

    SINES = 4

    def __init__(self, name: str = "harmonics", control_hz: float = 20.0) -> None:
        super().__init__(name, self._sum, control_hz)
        self._coefficients: dict[int, Array] = {}

    def _sum(self, stream: np.random.Generator, last: Array, step: int, dt: float) -> Array:
        if step == 0:
            weights = stream.random((self.SINES, ACTION_SIZE))
            weights *= stream.random(ACTION_SIZE) / weights.sum(axis=0)
            frequencies = 0.1 * 20.0 ** stream.random((self.SINES, ACTION_SIZE))
            phases = 2.0 * np.pi * stream.random((self.SINES, ACTION_SIZE))
            self._coefficients[id(stream)] = np.stack([weights, frequencies, phases])
        weights, frequencies, phases = self._coefficients[id(stream)]
        total: Array = np.sum(weights * np.sin(2.0 * np.pi * frequencies * step * dt + phases), axis=0)
        return total


EXCITATIONS: Mapping[str, Callable[[float], Excitation]] = MappingProxyType(
    {
        "random": lambda control_hz: Excitation("random", uniform, control_hz),
        "ou_quick": lambda control_hz: Excitation("ou_quick", _ornstein_uhlenbeck(0.3, 0.5), control_hz),
        "ou_slow": lambda control_hz: Excitation("ou_slow", _ornstein_uhlenbeck(0.15, 2.0), control_hz),
        "ou_strong": lambda control_hz: Excitation("ou_strong", _ornstein_uhlenbeck(0.6, 1.0), control_hz),
        "harmonics": lambda control_hz: RandomHarmonics("harmonics", control_hz),
        "switching": lambda control_hz: Excitation("switching", switching(0.5), control_hz),
    }
)
"""Each by its name, made for so many control steps per second."""
BASELINES: Mapping[str, Callable[[float], Excitation]] = MappingProxyType(
    {"zero": lambda control_hz: Excitation("zero", zero, control_hz), **EXCITATIONS}
)
"""The same, and the agent without any."""
DESCRIPTIONS: Mapping[str, str] = MappingProxyType(
    {
        "zero": "The action 0, the middle of every range",
        "random": "Uniform random actions, new at every step",
        "ou_quick": "Random actions that change smoothly within half a second",
        "ou_slow": "Weak random actions that change smoothly within two seconds",
        "ou_strong": "Strong random actions that change smoothly within a second",
        "harmonics": "Sums of four sines of random size and frequency",
        "switching": "Every action thrown between its two extremes, once a second",
    }
)
"""A sentence on each baseline."""
