"""The belief's correlations as a part of the observation."""

import gymnasium as gym
import numpy as np
import pytest

import jawenv  # noqa: F401  registers the environments
from jawenv.base.errors import InputError
from jawenv.envs.observation import observation_layout

ID = "jawenv/Jaw-v3"


@pytest.mark.parametrize("knowledge", ["exact", "imaged"])
def test_they_are_those_of_the_belief_in_info_and_change_nothing_else(knowledge):
    arguments = {"episode_s": 1.0, "comfort_budget_s": 0.03, "knowledge": knowledge}
    env = gym.make_vec(ID, 3, observe_correlations=True, **arguments)
    plain = gym.make_vec(ID, 3, **arguments)
    place = observation_layout(budget=True, correlations=True)["correlations"]
    seen, plainly = env.reset(seed=4)[0], plain.reset(seed=4)[0]
    assert (seen[:, place] == 0.0).all()
    draws = np.random.default_rng(1)
    for _ in range(7):  # one more than an episode has: the last begins anew
        np.testing.assert_array_equal(seen[:, : place.start], plainly)
        actions = draws.uniform(-1.0, 1.0, (3, 4)).astype(np.float32)
        (seen, _, _, _, info), plainly = env.step(actions), plain.step(actions)[0]
        covariance = info["belief_cov"]
        for i in range(3):
            sd = np.sqrt(np.diag(covariance[i]))
            expected = (covariance[i] / np.outer(sd, sd))[np.triu_indices(12, 1)]
            np.testing.assert_allclose(seen[i, place], expected, atol=1e-6)


def test_one_muscle_has_none():
    with pytest.raises(InputError, match=r"observe_correlations is True; allowed where one muscle .*: False"):
        gym.make("jawenv/JawHinge-v3", observe_correlations=True)
