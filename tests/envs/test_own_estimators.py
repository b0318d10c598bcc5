"""An estimator of the user's feeds observation, info and reward; the device's own filter is the reference."""

import copy
import pickle

import gymnasium as gym
import numpy as np
import pytest
from test_copies import actions, assert_same

import jawenv
from jawenv.envs.own_estimators import EpisodeStart

ID = "jawenv/Jaw-v3"


class Replayed:
    """The environments' filter, through the protocol."""

    def __init__(self, every):
        self.filter = jawenv.OnlineFilter(cohort="trismus", every=every)

    def reset(self, start):
        self.filter.reset(start.start_mean)

    def update(self, measured, samples):
        last = self.filter.update(measured, samples)
        self.belief = last.log_mean, last.log_cov


class Shrinking:
    """A belief of known numbers: after k readings the prior's sds over 1 + k / 100, and its mean + 0.1."""

    def reset(self, start):
        self.start, self.number = start, 0

    def update(self, measured, samples):
        assert measured.shape == (12,) and (samples is None) == (self.number == 0)
        self.number += 1

    @property
    def belief(self):
        prior = self.start.prior
        return prior.mean + 0.1, np.diag((prior.sd / (1.0 + 0.01 * self.number)) ** 2)


@pytest.mark.parametrize(
    ("control", "reward"), [("targets", "uncertainty"), ("force", "score"), ("trajectory", "worst"), ("force", "bound")]
)
def test_the_environments_filter_as_an_own_one_gives_the_same_to_the_bit(control, reward):
    """Two episodes, the second with a patient whose head is tilted; an own belief counts as settled at once."""

    def seen(returned):
        *rest, info = returned
        return *rest, {key: value for key, value in info.items() if key != "settled"}

    arguments = {"control": control, "reward": reward, "episode_s": 2.0}
    env = gym.make(ID, **arguments)
    own = gym.make(ID, **arguments, estimator=Replayed(env.unwrapped.configuration.ticks_per_step))
    assert_same(seen(own.reset(seed=5000)), seen(env.reset(seed=5000)))
    for k in range(2):
        for (action,) in actions(1, 10, seed=k):
            expected, step = env.step(action), own.step(action)
            assert step[4]["settled"]
            assert_same(seen(step), seen(expected))
        assert_same(seen(own.reset()), seen(env.reset()))


def test_reward_info_and_observation_are_those_of_its_belief():
    env = gym.make(ID, estimator=Shrinking())
    observation, info = env.reset(seed=5000)
    prior = env.unwrapped.prior
    assert info["information_claimed"] == pytest.approx(12 * np.log(1.01))
    observation, reward, *_, info = env.step(np.zeros(4, np.float32))
    sd = prior.sd / 1.21
    np.testing.assert_allclose(info["belief_sd"], sd)
    np.testing.assert_allclose(info["belief_mean"], prior.mean + 0.1)
    error = (info["belief_mean"] - info["truth"]) / sd
    assert info["nees"] == pytest.approx(error @ error)
    before = (prior.mean - info["truth"]) / prior.sd
    assert info["information_true"] == pytest.approx(12 * np.log(1.21) + 0.5 * (before @ before - error @ error))
    assert reward == pytest.approx(12 * np.log(1.21 / 1.01))
    np.testing.assert_allclose(observation[:12], 0.1 / prior.sd, rtol=1e-6)
    np.testing.assert_allclose(observation[12:24], -np.log10(1.21), rtol=1e-6)


def test_the_jaw_moves_as_without_it():
    """The law of targets control has the device's own belief, whatever another one says."""
    plain, own = gym.make(ID), gym.make(ID, estimator=Shrinking())
    plain.reset(seed=5000), own.reset(seed=5000)
    for (action,) in actions(1, 10):
        expected, step = plain.step(action), own.step(action)
        np.testing.assert_array_equal(step[4]["jaw_state"], expected[4]["jaw_state"])
        np.testing.assert_array_equal(step[0][24:54], expected[0][24:54])


def test_what_it_is_told():
    env = gym.make(ID, estimator=Shrinking(), device={"cell_gain": 0.02}, control="force").unwrapped
    tilted = jawenv.cohort("trismus").draw(np.random.default_rng(0)).model_copy(update={"head_tilt_deg": 10.0})
    env.reset(seed=5000, options={"patient": tilted})
    start = env.simulation.own_estimators.each[0].start
    assert isinstance(start, EpisodeStart)
    assert start.parameter_names == env.parameter_names and start.prior is env.prior
    assert (start.tick_s, start.ticks_per_step, start.gain_sd) == (0.01, 5, 0.02)
    assert start.jaw["gravity"][0] == pytest.approx(9.81 * np.sin(np.radians(10.0)), rel=1e-3)
    np.testing.assert_allclose(start.measurement_sd, np.repeat([1e-4, np.radians(0.1), 1e-3, 0.02], 3))
    np.testing.assert_allclose(start.wrench_sd[:3] ** 2, 0.1**2 + 0.5 * 0.04**2)


@pytest.mark.parametrize("mode", ["next_step", "same_step"])
def test_every_world_of_the_vector_form_has_its_own(mode):
    """World i equals the single environment; a reset begins the estimator of that world alone."""
    vec = gym.make_vec(ID, num_envs=3, estimator=Shrinking(), episode_s=1.0, autoreset_mode=mode)
    single = gym.make(ID, estimator=Shrinking(), episode_s=1.0)
    first, info = vec.reset(seed=5000)
    alone = [single.reset(seed=5002)]
    rows = [(first[2], info["belief_sd"][2])]
    for row in actions(3, 4):
        observation, *_, info = vec.step(row)
        alone.append(single.step(row[2]))
        rows.append((observation[2], info["belief_sd"][2]))
    for (seen, sd), expected in zip(rows, alone, strict=True):
        np.testing.assert_array_equal(seen, expected[0])
        np.testing.assert_array_equal(sd, expected[-1]["belief_sd"])
    for row in actions(3, 2, seed=1):
        vec.step(row)
    numbers = [each.number for each in vec.simulation.own_estimators.each]
    assert numbers == [1 if mode == "next_step" else 21] * 3
    sync = gym.make_vec(ID, num_envs=2, estimator=Shrinking(), vectorization_mode="sync")
    sync.reset(seed=5000)
    assert len({id(each.unwrapped.simulation.own_estimators.each[0]) for each in sync.envs}) == 2


@pytest.mark.parametrize("way", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_copies_go_on_alike(way):
    env = gym.make(ID, estimator=Replayed(20))
    env.reset(seed=5000)
    for (action,) in actions(1, 5):
        env.step(action)
    other = way(env)
    expected = [env.step(action) for (action,) in actions(1, 5, seed=1)]
    for (action,), step in zip(actions(1, 5, seed=1), expected, strict=True):
        assert_same(other.step(action), step)


class Broken(Shrinking):
    """What ``belief`` is after some readings."""

    def __init__(self, value, after):
        self.value, self.after = value, after

    @property
    def belief(self):
        return super().belief if self.number < self.after else self.value


ONES = np.ones(12)


@pytest.mark.parametrize("after", [1, 30])
@pytest.mark.parametrize(
    "value", [None, (ONES, ONES), (np.full(12, np.nan), np.eye(12)), (ONES, np.triu(np.ones((12, 12))))]
)
def test_a_belief_that_is_none_is_one_line_and_asks_for_a_reset(value, after):
    env = gym.make(ID, estimator=Broken(value, after)).unwrapped
    with pytest.raises(jawenv.InputError):
        env.reset(seed=5000)
        for _ in range(2):
            env.step(np.zeros(4, np.float32))
    own = env.simulation.own_estimators
    if after > 1:
        with pytest.raises(gym.error.ResetNeeded, match="estimator has failed"):
            env.step(np.zeros(4, np.float32))
    own.each[0].after = 1000
    env.reset(seed=5000)
    env.step(np.zeros(4, np.float32))


def test_a_covariance_that_is_not_positive_definite_ends_the_episode():
    env = gym.make(ID, estimator=Broken((ONES, np.zeros((12, 12))), 10))
    env.reset(seed=5000)
    _, reward, terminated, *_ = env.step(np.zeros(4, np.float32))
    assert terminated and np.isfinite(reward)


def test_players_and_scores_take_it():
    arguments = {"estimator": Shrinking(), "episode_s": 1.0}
    played = jawenv.play(jawenv.Player("hold_still", control="force"), patients=2, seed=5000, env_kwargs=arguments)
    np.testing.assert_allclose(played.belief_sd[:, -1], jawenv.cohort("trismus").prior.sd / 2.01 * np.ones((2, 1)))


@pytest.mark.parametrize("value", ["kalman", 3, Shrinking, object()])
def test_what_is_no_estimator_is_refused(value):
    with pytest.raises(jawenv.InputError):
        gym.make(ID, estimator=value)
