"""``estimator="none"``: the world without a belief about the muscles."""

import gymnasium as gym
import numpy as np
import pytest
from test_copies import actions

ID = "jawenv/Jaw-v3"


@pytest.mark.parametrize("control", ["force", "trajectory"])
def test_the_jaw_moves_as_with_the_filter_to_the_bit(control):
    """Nothing of the filter acts on it; the bound is that of the truth alone."""
    arguments = {"control": control, "reward": "bound"}
    plain, none = gym.make(ID, **arguments), gym.make(ID, **arguments, estimator="none")
    plain.reset(seed=5000), none.reset(seed=5000)
    for (action,) in actions(1, 20):
        expected, step = plain.step(action), none.step(action)
        assert step[1] == expected[1] and step[2] == expected[2]
        for key in ("jaw_state", "bound_sd", "cost", "comfort_force", "governor", "truth"):
            np.testing.assert_array_equal(step[4][key], expected[4][key])


@pytest.mark.parametrize("arguments", [{}, {"knowledge": "imaged"}, {"device": {"unmodelled_time_s": 0.5}}])
def test_the_belief_is_the_prior_and_pays_nothing(arguments):
    env = gym.make(ID, estimator="none", reward="mixed", comfort_weight=2.0, control="force", **arguments)
    _, info = env.reset(seed=5000)
    prior = env.unwrapped.prior
    for (action,) in actions(1, 10):
        observation, reward, terminated, _, info = env.step(action)
        np.testing.assert_array_equal(info["belief_mean"], prior.mean)
        np.testing.assert_array_equal(info["belief_sd"], prior.sd)
        assert not observation[:24].any()
        assert reward == pytest.approx(-2.0 * info["cost"] / 20.0, abs=1e-12)
        assert info["misfit"] == info["gated"] == info["information_claimed"] == 0.0
        if terminated:
            break
    error = (info["truth"] - prior.mean) / prior.sd
    assert info["nees"] == pytest.approx(error @ error)


def test_the_motion_follows_the_encoders():
    """Its error is larger than with the filter, and small beside the motion: the law of targets control reads it."""
    errors = {}
    for estimator in (None, "none"):
        env = gym.make_vec(ID, num_envs=8, estimator=estimator, autoreset_mode="disabled")
        env.reset(seed=5000)
        found = []
        for action in 0.6 * actions(8, 50):
            *_, terminated, _, info = env.step(action.astype(np.float32))
            assert not terminated.any()
            found.append(env.simulation.worlds["known"]["belief"]["motion"][:, :5] - info["jaw_state"][:, :5])
        errors[estimator] = np.sqrt(np.mean(np.square(found), axis=(0, 1)))
    assert (errors["none"] > errors[None]).all()
    assert (errors["none"] < [5e-4, 1e-3, 0.003, 0.01, 0.01]).all()  # m, m, rad: the encoders' are 1e-4 and 0.0017
