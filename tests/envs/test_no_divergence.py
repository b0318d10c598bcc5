"""The filter stays finite under actions that are not made for it."""

import gymnasium as gym
import numpy as np
import pytest

ACTIONS = {
    "swinging": lambda k, n, rng: (
        0.4 * np.sin((2 + 0.3 * np.arange(n)[:, None] + np.arange(4)) * k / 20 + np.arange(4))
    ),
    "random": lambda k, n, rng: rng.uniform(-1, 1, (n, 4)),
}


@pytest.mark.parametrize("name", ACTIONS)
@pytest.mark.parametrize("cohort", ["trismus", "healthy", "severe", "one_sided", "blockage"])
def test_the_belief_stays_a_number(cohort, name, rng):
    env = gym.make_vec("jawenv/Jaw-v0", num_envs=48, cohort=cohort, autoreset_mode="disabled", episode_s=8.0)
    env.reset(seed=5000)
    for k in range(159):
        *_, terminated, _, info = env.step(ACTIONS[name](k, 48, rng).astype(np.float32))
        assert np.isfinite(info["belief_cov"]).all()
    assert (terminated == info["violation"]).all()
