"""Sensors without noise: a filter that stays finite and honest, over whole episodes."""

import gymnasium as gym
import numpy as np
import pytest

from jawenv.filter.readings import least_noise
from jawenv.recordings.of_simulation import record_of
from jawenv.recordings.record_filter import TensionFilter

ENCODERS = dict.fromkeys(
    ("encoder_position_mm", "encoder_angle_deg", "encoder_velocity_mm_s", "encoder_rate_rad_s"), 0.0
)
CELL = dict.fromkeys(("cell_force_N", "cell_moment_N_m", "cell_gain"), 0.0)
UNMODELLED = dict.fromkeys(("unmodelled_force_N", "unmodelled_moment_N_m"), 0.0)
DEVICES = {"sensors": ENCODERS | CELL, "everything": ENCODERS | CELL | UNMODELLED}
SHARE = {"targets": 1.0, "force": 0.5, "trajectory": 1.0}  # of the whole command: full thrusts cross hard limits
WORLDS, CLAIMED = 4, 12 * 4


@pytest.mark.parametrize("control", ["targets", "force", "trajectory"])
@pytest.mark.parametrize("device", DEVICES)
def test_a_whole_episode_is_finite_and_honest(device, control):
    """NEES of four patients with 12 parameters each is chi-squared of 48, whose 99.9th percentile is 84."""
    env = gym.make_vec("jawenv/Jaw-v3", num_envs=WORLDS, control=control, device=DEVICES[device])
    _, info = env.reset(seed=5000)
    rng = np.random.default_rng(0)
    for k in range(env.configuration.steps):
        wave = 0.5 * np.sin(2.0 * np.pi * 0.3 * k / env.configuration.steps_per_s + np.arange(4.0))
        action = (SHARE[control] * (0.5 * rng.uniform(-1.0, 1.0, (WORLDS, 4)) + wave)).astype(np.float32)
        observation, reward, terminated, _, info = env.step(action)
        assert np.isfinite(observation).all() and np.isfinite(reward).all() and not terminated.any()
        assert all(np.isfinite(value).all() for value in info.values())
    assert info["nees"].sum() < 84.0
    assert info["misfit"].max() < 1.0
    assert info["belief_sd"].max() < 0.15  # something was learnt


def test_readings_have_no_noise():
    env = gym.make("jawenv/Jaw-v3", control="force", device=DEVICES["everything"], record=True).unwrapped
    env.reset(seed=5000)
    for _ in range(10):
        env.step(np.full(4, 0.4, np.float32))
    record = record_of(env.simulation, 0)
    single = np.float32  # to which readings are rounded
    np.testing.assert_array_equal(record.samples, record.wrenches.astype(single))
    np.testing.assert_array_equal(record.measured[:, 3], record.states[:, 2].astype(single))
    np.testing.assert_allclose(record.measurement_sd, np.repeat(least_noise.ENCODER_SDS, 3))
    np.testing.assert_allclose(record.wrench_sd, np.repeat(least_noise.WRENCH_SDS, 3))


def test_a_quiet_load_cell_that_repeats_itself_has_not_failed():
    """No motor pushes, so it reads zero throughout; a record's filter has the belief of the environment's."""
    env = gym.make("jawenv/Jaw-v3", control="force", device=CELL, record=True).unwrapped
    env.reset(seed=5000)
    for _ in range(20):
        info = env.step(np.zeros(4, np.float32))[4]
        assert info["left_out"] == 0.0
    record = record_of(env.simulation, 0)
    assert not record.samples.any()
    np.testing.assert_array_equal(TensionFilter().estimate(record).mean[-1], info["belief_mean"])


def test_less_noise_than_the_least_is_as_much_as_none():
    found = []
    for share in (0.0, 0.5):
        sds = dict(zip(ENCODERS, share * np.array([0.05, 0.05, 0.5, 0.01]), strict=True))
        simulation = gym.make("jawenv/Jaw-v3", device=sds).unwrapped.simulation
        found.append(simulation.settings["filter"]["measurement_variance"].copy())
    np.testing.assert_array_equal(*found)
    default = gym.make("jawenv/Jaw-v3").unwrapped.simulation.settings["filter"]["measurement_variance"][0]
    np.testing.assert_allclose(np.sqrt(default), np.repeat([1e-4, np.radians(0.1), 1e-3, 0.02], 3))
