"""What a policy is shown: its own parts of an observation, and the belief beside its own prior."""

import gymnasium as gym
import numpy as np
import pytest

from jawenv.anatomy import cohort
from jawenv.base.errors import InputError
from jawenv.envs.observation import OBSERVATION_LAYOUT, Parts
from jawenv.playing.agents import introduce
from jawenv.playing.policies.card import policy_folder
from jawenv.playing.policies.inputs import OwnParts, OwnPrior
from jawenv.playing.policies.plain import load_plain


def observation_of(mean, sd, prior):
    rows = np.zeros((1, 63), dtype=np.float32)
    rows[0, OBSERVATION_LAYOUT["belief_mean"]] = (mean - prior.mean) / prior.sd
    rows[0, OBSERVATION_LAYOUT["belief_sd"]] = np.log10(sd / prior.sd)
    return rows


def shown_to(known, given):
    own = OwnParts(known, "p")
    own.take(given)
    return own


def test_one_belief_is_shown_alike_under_two_priors():
    own, other = cohort("anyone").prior, cohort("severe").prior
    mean, sd = other.mean + 0.3, 0.2 * other.sd
    shown = OwnPrior(own)
    shown.take(other)
    np.testing.assert_allclose(shown(observation_of(mean, sd, other)), observation_of(mean, sd, own), atol=1e-5)
    shown.take(own)
    rows = observation_of(mean, sd, own)
    assert shown(rows) is rows


def test_parts_are_taken_by_name_and_nothing_is_spent_where_no_budget_is_kept():
    rows = np.arange(2 * 70, dtype=np.float32).reshape(2, 70)
    asked, plain, budget = Parts(asked=True), Parts(), Parts(budget=True)
    np.testing.assert_array_equal(shown_to(plain, asked)(rows), rows[:, :63])
    with_budget = shown_to(budget, plain)(rows[:, :63])
    np.testing.assert_array_equal(with_budget[:, :63], rows[:, :63])
    assert (with_budget[:, 63] == 0.0).all()
    np.testing.assert_array_equal(shown_to(budget, asked)(rows)[:, 63], 0.0)
    assert shown_to(asked, asked)(rows) is rows


@pytest.mark.parametrize(
    ("given", "lacking"), [(Parts(), "no asked and discomfort"), (Parts(6, asked=True), "6 parameters")]
)
def test_a_policy_names_the_parts_that_it_misses(given, lacking):
    with pytest.raises(InputError, match=f"^p: the environment's observation has {lacking}; allowed: belief_mean, "):
        OwnParts(Parts(asked=True), "p").take(given)


def test_another_part_is_not_read_as_the_budget_that_is_as_long():
    class Alarm(gym.ObservationWrapper):
        def observation(self, observation):
            return np.append(observation, np.float32(3.0))

    env, agent = Alarm(gym.make("jawenv/Jaw-v3", episode_s=1.0)), load_plain(policy_folder("apg_anyone"))
    observation, _ = env.reset(seed=0)
    introduce(agent, env)
    with pytest.raises(InputError, match="an observation has 64 values; allowed: 63, of belief_mean, "):
        agent.predict(observation)
