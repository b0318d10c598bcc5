"""Actions that look at nothing: seeded per world, within bounds, in either shape, of the law that they claim."""

import numpy as np
import pytest

from jawenv.playing.excitation import BASELINES, Excitation, ornstein_uhlenbeck

HZ = 20.0


def drawn(worlds: int, seed: int, steps: int = 5, name: str = "random") -> np.ndarray:
    agent = BASELINES[name](HZ)
    agent.reset(worlds, seed)
    observation = np.zeros((worlds, 7), dtype=np.float32)
    return np.stack([agent.predict(observation)[0] for _ in range(steps)])


def test_actions_are_uniform_within_the_box() -> None:
    actions = drawn(200, seed=3, steps=50)
    assert actions.dtype == np.float32 and actions.shape == (50, 200, 4)
    assert np.abs(actions).max() <= 1.0
    assert abs(actions.mean()) < 0.02 and abs(actions.std() - 1 / np.sqrt(3)) < 0.02


@pytest.mark.parametrize("name", ["random", "ou_strong"])
def test_same_seed_same_actions_other_seed_others(name: str) -> None:
    first = drawn(3, seed=5, name=name)
    np.testing.assert_array_equal(first, drawn(3, seed=5, name=name))
    assert not np.array_equal(first, drawn(3, seed=6, name=name))
    assert np.abs(first).max() <= 1.0 and first.dtype == np.float32


@pytest.mark.parametrize("name", ["random", "ou_strong"])
def test_a_world_draws_the_same_whatever_its_company(name: str) -> None:
    """World i of seed s is the single world of seed s + i, as in the environment."""
    many = drawn(4, seed=10, name=name)
    for world in range(4):
        np.testing.assert_array_equal(many[:, world], drawn(1, seed=10 + world, name=name)[:, 0])


def test_smooth_noise_is_stationary_and_forgets_with_its_time_constant() -> None:
    agent = Excitation("ou_quick", ornstein_uhlenbeck(0.3, 0.5), HZ)
    agent.reset(400, 7)
    actions = np.stack([agent.predict(np.zeros((400, 7), dtype=np.float32))[0] for _ in range(60)])
    assert actions.std() == pytest.approx(0.3, rel=0.05)
    lag = 10
    correlation = np.mean(actions[lag:] * actions[:-lag]) / np.mean(actions**2)
    assert correlation == pytest.approx(np.exp(-lag / HZ / 0.5), abs=0.05)


def test_zero_does_nothing() -> None:
    agent = BASELINES["zero"](HZ)
    agent.reset(3, seed=0)
    actions, _ = agent.predict(np.ones((3, 63), dtype=np.float32))
    np.testing.assert_array_equal(actions, np.zeros((3, 4), dtype=np.float32))
