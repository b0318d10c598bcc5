"""Actions that look at nothing: seeded per world, within bounds, in either shape, of the law that they claim."""

import numpy as np
import pytest

from jawenv.playing.excitation import BASELINES, EXCITATIONS

HZ = 20.0


def drawn(worlds: int, seed: int, steps: int = 5, name: str = "random") -> np.ndarray:
    agent = EXCITATIONS[name](HZ)
    agent.reset(worlds, seed)
    observation = np.zeros((worlds, 7), dtype=np.float32)
    return np.stack([agent.predict(observation)[0] for _ in range(steps)])


def test_actions_are_uniform_within_the_box() -> None:
    actions = drawn(200, seed=3, steps=50)
    assert actions.dtype == np.float32 and actions.shape == (50, 200, 4)
    assert np.abs(actions).max() <= 1.0
    assert abs(actions.mean()) < 0.02 and abs(actions.std() - 1 / np.sqrt(3)) < 0.02


@pytest.mark.parametrize("name", EXCITATIONS)
def test_same_seed_same_actions_other_seed_others(name: str) -> None:
    first = drawn(3, seed=5, name=name)
    np.testing.assert_array_equal(first, drawn(3, seed=5, name=name))
    assert not np.array_equal(first, drawn(3, seed=6, name=name))
    assert np.abs(first).max() <= 1.0 and first.dtype == np.float32


@pytest.mark.parametrize("name", EXCITATIONS)
def test_a_world_draws_the_same_whatever_its_company(name: str) -> None:
    """World i of seed s is the single world of seed s + i, as in the environment."""
    many = drawn(4, seed=10, name=name)
    for world in range(4):
        np.testing.assert_array_equal(many[:, world], drawn(1, seed=10 + world, name=name)[:, 0])


@pytest.mark.parametrize(("name", "sd", "time_s"), [("ou_quick", 0.3, 0.5), ("ou_slow", 0.15, 2.0)])
def test_smooth_noise_is_stationary_and_forgets_with_its_time_constant(name: str, sd: float, time_s: float) -> None:
    actions = drawn(400, seed=7, steps=60, name=name)
    assert actions.std() == pytest.approx(sd, rel=0.05)
    lag = 10
    correlation = np.mean(actions[lag:] * actions[:-lag]) / np.mean(actions**2)
    assert correlation == pytest.approx(np.exp(-lag / HZ / time_s), abs=0.05)


def test_switching_knows_the_extremes_alone_and_holds_them() -> None:
    actions = drawn(200, seed=7, steps=60, name="switching")
    assert set(np.unique(actions)) == {-1.0, 1.0}
    changed = np.mean(actions[1:] != actions[:-1])
    assert changed == pytest.approx(0.5 * (1.0 - np.exp(-1.0 / HZ / 0.5)), abs=0.01)


def test_harmonics_are_sums_of_few_slow_sines() -> None:
    """None of 2 Hz or less changes faster than its amplitude, at most 1 in sum, allows."""
    actions = drawn(50, seed=7, steps=100, name="harmonics").astype(float)
    assert np.abs(np.diff(actions, axis=0)).max() <= 2.0 * np.pi * 2.0 / HZ + 1e-6
    assert np.abs(actions).max() > 0.5


def test_zero_does_nothing() -> None:
    agent = BASELINES["zero"](HZ)
    agent.reset(3, seed=0)
    actions, _ = agent.predict(np.ones((3, 63), dtype=np.float32))
    np.testing.assert_array_equal(actions, np.zeros((3, 4), dtype=np.float32))
