"""A budget of discomfort that the device keeps: what it saves, what it shows, and what it refuses."""

import gymnasium as gym
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import jawenv
from jawenv.base.errors import InputError
from jawenv.device.channels import CHANNELS
from jawenv.device.comfort import COMFORT_LIMITS, N_LIMITS
from jawenv.device.guard import DRIVERS, RELEASE, TRACKER, keep_budget
from jawenv.envs.observation import Parts
from jawenv.playing.excitation import BASELINES
from jawenv.playing.maneuvers import Player

ID, BUDGET_S = "jawenv/Jaw-v3", 1.0 / 30.0
FINITE = st.floats(-20.0, 1.0)


def budget_of(whole=BUDGET_S, spent=0.0):
    budget = np.zeros(1, dtype=TRACKER)[0]["budget"]
    budget["total"], budget["spent"], budget["hard"] = whole, spent, 1.5
    budget["size"], budget["margin"] = 1.0, 1.0
    return budget


def discomfort_of(agent, cohort, patients, **arguments):
    kwargs = {"cohort": cohort, "episode_s": 10.0, "track_bound": False, **arguments}
    return jawenv.score(jawenv.play(agent, patients=patients, seed=5300, env_kwargs=kwargs)).discomfort_s


@given(st.lists(st.lists(FINITE, min_size=N_LIMITS, max_size=N_LIMITS), min_size=1, max_size=30))
@settings(deadline=None, max_examples=60)
def test_whatever_is_felt_sizes_stay_between_0_and_1_and_the_spent_grows(margins):
    budget, before = budget_of(), 0.0
    for margin in margins:
        keep_budget(budget, np.array(margin), 0.05)
        assert ((budget["size"] >= 0.0) & (budget["size"] <= 1.0)).all()
        assert budget["spent"] >= before
        before = float(budget["spent"])


@pytest.mark.parametrize("limit", COMFORT_LIMITS)
def test_only_channels_that_drive_a_limit_give_way(limit):
    budget, margin = budget_of(spent=BUDGET_S), np.ones(N_LIMITS)
    margin[COMFORT_LIMITS.index(limit)] = 0.05
    keep_budget(budget, margin, 0.05)
    gave_way = [channel for channel, size in zip(CHANNELS, budget["size"], strict=True) if size < 1.0]
    assert gave_way == [channel for channel in CHANNELS if channel in DRIVERS[limit]]


def test_more_margin_is_asked_for_as_the_budget_is_spent():
    sizes = []
    for spent in (0.0, 0.5 * BUDGET_S):
        budget, margin = budget_of(spent=spent), np.full(N_LIMITS, 0.0)
        budget["margin"] = margin
        keep_budget(budget, margin, 0.05)
        sizes.append(float(budget["size"].min()))
    assert sizes[0] > sizes[1] + 0.05


@pytest.mark.parametrize("limit", COMFORT_LIMITS)
def test_motors_let_go_where_margin_is_missing_but_for_speed(limit):
    budget, margin = budget_of(whole=10.0), np.ones(N_LIMITS)
    keep_budget(budget, margin, 0.05)
    assert (budget["release"] == 0.0).all()
    margin[COMFORT_LIMITS.index(limit)] = -1.0
    keep_budget(budget, margin, 0.05)
    drive = [channel in DRIVERS[limit] and limit != "speed" for channel in CHANNELS]
    np.testing.assert_array_equal(budget["release"], RELEASE * np.array(drive))


def test_a_stiff_jaw_is_let_go_within_a_budget():
    """Its motors hold it by thrusts that push it aside as it closes: targets that shrink do not take them back."""
    kept = discomfort_of(Player("information_optimal"), "blockage", 24, comfort_budget_s=BUDGET_S)
    assert np.mean(kept > BUDGET_S) <= 0.05


@pytest.mark.parametrize("agent", ["refined", "random"])
@pytest.mark.parametrize("cohort", ["healthy", "one_sided"])
def test_a_budget_is_kept_for_most_patients(agent, cohort):
    player = BASELINES[agent](5.0) if agent in BASELINES else Player(agent)
    free, kept = (discomfort_of(player, cohort, 16, comfort_budget_s=budget) for budget in (None, BUDGET_S))
    assert free.mean() > BUDGET_S
    assert kept.mean() < 0.5 * free.mean() and np.mean(kept > BUDGET_S) <= 0.07


def test_info_and_observation_have_what_is_spent_and_it_is_about_true():
    env = gym.make_vec(ID, 8, cohort="healthy", comfort_budget_s=BUDGET_S, episode_s=6.0, autoreset_mode="disabled")
    layout, player = Parts(budget=True).layout, Player("refined")
    observation, info = env.reset(seed=5400)
    assert observation.shape == (8, 64) and (info["spent"] == 0.0).all()
    true = np.zeros(8)
    for _ in range(30):
        observation, *_, info = env.step(player.predict(observation)[0])
        true += 0.2 * info["cost"]
    np.testing.assert_allclose(observation[:, layout["spent"]][:, 0], info["spent"], rtol=1e-5)
    assert np.corrcoef(true, info["spent"])[0, 1] > 0.8
    assert true.mean() / BUDGET_S == pytest.approx(info["spent"].mean(), rel=0.3)
    _, info = env.reset(seed=5400)
    assert (info["spent"] == 0.0).all()


def test_a_question_keeps_its_own_end():
    env = gym.make_vec(ID, 2, asked="random", comfort_budget_s=0.03)
    observation, info = env.reset(seed=0)
    assert observation.shape == (2, 70) and "spent" in info


def test_a_budget_is_refused_where_the_device_follows_no_targets():
    for control in ("force", "trajectory"):
        with pytest.raises(InputError, match=r"comfort_budget_s is 0.03; allowed in .* control: none"):
            gym.make(ID, control=control, comfort_budget_s=0.03)
    for wrong in (0.0, -1.0, np.nan, "much"):
        with pytest.raises(InputError, match="comfort_budget_s"):
            gym.make(ID, comfort_budget_s=wrong)
