"""The random policy: seeded per world, within bounds, in either shape."""

import numpy as np

from agents.baselines import RandomPolicy


def drawn(worlds: int, seed: int, steps: int = 5) -> np.ndarray:
    agent = RandomPolicy()
    agent.reset(worlds, seed)
    observation = np.zeros((worlds, 7), dtype=np.float32)
    return np.stack([agent.predict(observation)[0] for _ in range(steps)])


def test_actions_are_uniform_within_the_box() -> None:
    actions = drawn(200, seed=3, steps=50)
    assert actions.dtype == np.float32 and actions.shape == (50, 200, 4)
    assert np.abs(actions).max() <= 1.0
    assert abs(actions.mean()) < 0.02 and abs(actions.std() - 1 / np.sqrt(3)) < 0.02


def test_same_seed_same_actions_other_seed_others() -> None:
    np.testing.assert_array_equal(drawn(3, seed=5), drawn(3, seed=5))
    assert not np.array_equal(drawn(3, seed=5), drawn(3, seed=6))


def test_a_world_draws_the_same_whatever_its_company() -> None:
    """World i of seed s is the single world of seed s + i, as in the environment."""
    many = drawn(4, seed=10)
    for world in range(4):
        np.testing.assert_array_equal(many[:, world], drawn(1, seed=10 + world)[:, 0])


def test_one_observation_gets_one_action() -> None:
    agent = RandomPolicy()
    agent.reset(1, 5)
    action, state = agent.predict(np.zeros(7))
    assert action.shape == (4,) and state is None
    np.testing.assert_array_equal(action, drawn(1, seed=5, steps=1)[0, 0])
