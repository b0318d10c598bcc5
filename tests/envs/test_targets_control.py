"""Targets control: the device's own law inside the environment against the same law outside, and what it refuses."""

import gymnasium as gym
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import jawenv
from jawenv.base.errors import InputError
from jawenv.device.channels import FASTEST_TARGET, LOWEST
from jawenv.device.device import LAW_TICKS
from jawenv.device.guard import TRACKER
from jawenv.envs.observation import OBSERVATION_LAYOUT
from jawenv.envs.world.tracking import aim, follow_all, move_targets
from jawenv.metrics.calibration import nees, nees_band
from jawenv.playing.maneuvers import Player, maneuver_names
from jawenv.playing.maneuvers.maneuver import action_of

ID = "jawenv/Jaw-v3"
PERIOD_S = 0.2


def law_outside(seed: int, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Observations and beliefs of trajectory control, driven every 50 ms by the law, as a user could write it."""
    env = gym.make_vec(ID, num_envs=1, control="trajectory", autoreset_mode="disabled")
    observation, info = env.reset(seed=seed)
    tracker, action = np.zeros(1, dtype=TRACKER), np.zeros((1, 4))
    device = env.unwrapped.simulation.device
    seen = []
    for goal in actions:
        aim(tracker[0], goal, PERIOD_S)
        for _ in range(4):
            follow_all(device, observation, 12, tracker, True, True, 0.05, action)
            move_targets(tracker[0], 0.05)
            observation, _, _, _, info = env.step(action)
        seen.append(observation[0])
    return np.array(seen), info["belief_mean"][0]


def test_the_device_follows_targets_as_the_law_outside_does():
    """Twenty steps of random targets: the motion is the same to what renewing the belief less often changes."""
    actions = np.random.default_rng(0).uniform(-0.8, 0.8, (20, 4))
    outside, mean_outside = law_outside(3, actions)
    env = gym.make(ID, control="targets").unwrapped
    env.reset(seed=3)
    for step, action in enumerate(actions):
        observation, _, _, _, info = env.step(action)
        np.testing.assert_allclose(
            observation[OBSERVATION_LAYOUT["jaw"]], outside[step][OBSERVATION_LAYOUT["jaw"]], atol=0.02
        )
    np.testing.assert_allclose(info["belief_mean"], mean_outside, atol=0.1)


@pytest.mark.parametrize("name", maneuver_names())
def test_a_maneuver_asks_the_device_for_its_targets(name):
    player = Player(name, control="targets")
    env = gym.make_vec(ID, num_envs=2, control="targets")
    observation, _ = env.reset(seed=0)
    for step in range(5):
        action, _ = player.predict(observation)
        wanted = player.maneuver.targets(np.array([(step + 1) * PERIOD_S])).value
        np.testing.assert_allclose(action, np.repeat(action_of(wanted), 2, axis=0), atol=1e-6)
        low = np.array(LOWEST)
        np.testing.assert_allclose(low + (action + 1.0) / 2.0 * (1.0 - low), np.repeat(wanted, 2, axis=0), atol=1e-6)


@given(st.lists(st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4), min_size=1, max_size=8))
@settings(deadline=None, max_examples=50)
def test_targets_stay_within_comfort_and_their_speed(actions):
    tracker = np.zeros(1, dtype=TRACKER)[0]
    for action in actions:
        aim(tracker, np.array(action), PERIOD_S)
        assert (np.abs(tracker["rate"]) <= np.array(FASTEST_TARGET) + 1e-12).all()
        for _ in range(4):
            move_targets(tracker, 0.05)
        assert (tracker["target"] >= np.array(LOWEST) - 1e-9).all() and (tracker["target"] <= 1.0 + 1e-9).all()


def test_the_observation_shows_the_targets_that_are_followed():
    env = gym.make(ID, control="targets").unwrapped
    observation, _ = env.reset(seed=0)
    np.testing.assert_array_equal(observation[OBSERVATION_LAYOUT["motor_target"]], 0.0)
    observation, *_ = env.step(np.array([-0.8, 0.3, -0.1, 0.2]))
    np.testing.assert_allclose(observation[OBSERVATION_LAYOUT["motor_target"]], [0.1, 0.3, -0.1, 0.2], atol=0.02)


def test_random_targets_hurt_nobody():
    """Sixteen patients, 30 s of uniform random targets: no hard limit, no governor to speak of, an honest belief."""
    from jawenv.playing.excitation import BASELINES

    played = jawenv.play(BASELINES["random"](5.0), patients=16, seed=5000, env_kwargs={"control": "targets"})
    assert not played.terminated.any()
    assert np.nanmean(played.governor) < 0.02
    shares = nees(played.belief_mean[:, -1] - played.truth, played.belief_cov[:, -1]) / 12.0
    assert np.mean(shares) < nees_band(16, 12, 0.999)[1] / 12.0


def test_rates_are_multiples_of_the_laws():
    assert gym.make(ID, control="targets").unwrapped.configuration.control_hz == 5.0
    assert gym.make(ID, control="force").unwrapped.configuration.control_hz == 20.0
    assert gym.make(ID, control="targets", control_hz=4).unwrapped.configuration.ticks_per_step == 25
    assert LAW_TICKS == 5
    with pytest.raises(InputError):
        gym.make(ID, control="targets", control_hz=50)
    with pytest.raises(InputError):
        gym.make(ID, control="targets", control_hz=8)
