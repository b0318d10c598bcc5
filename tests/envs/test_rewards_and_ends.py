"""What is paid, what an episode ends by, and what the agent must not see."""

import gymnasium as gym
import numpy as np
import pytest

import jawenv
from jawenv.device.comfort import COMFORT_LIMITS
from jawenv.envs.observation import OBSERVATION_LAYOUT
from jawenv.envs.world.observation import observe_world
from jawenv.metrics.calibration import claimed_information, true_information

ID = "jawenv/Jaw-v3"
TOTAL = {"uncertainty": "information_claimed", "bound": "information_bound", "score": "information_true"}


def swing(k):
    return np.array([0.3, 0.3, 0.3 * np.sin(0.6 * k), -0.3 * np.sin(0.6 * k)], dtype=np.float32)


def play(env, steps, action=swing):
    """Rewards, last observation and infos of the steps, from a reset with seed 4."""
    _, info = env.reset(seed=4)
    rewards, infos = [], [info]
    for k in range(steps):
        _, reward, terminated, truncated, info = env.step(action(k))
        rewards.append(reward)
        infos.append(info)
        assert not terminated
        assert truncated == (k == steps - 1)
    return np.array(rewards), infos


@pytest.mark.parametrize("reward", TOTAL)
def test_rewards_add_up_to_the_information_at_the_end(reward):
    """From the reset's, which the first measurement has moved from zero by nothing that counts."""
    rewards, infos = play(gym.make(ID, reward=reward, track_bound=True, episode_s=3.0, control="force"), 60)
    first, last = infos[0][TOTAL[reward]], infos[-1][TOTAL[reward]]
    assert rewards.sum() == pytest.approx(last - first, abs=1e-9)
    assert first == pytest.approx(0.0, abs=1e-9)
    assert abs(last) > 1.0


@pytest.mark.parametrize("reward", ["worst", "mixed"])
def test_the_reward_for_the_worst_sd_follows_the_sixth_norm(reward):
    rewards, infos = play(gym.make(ID, reward=reward, episode_s=3.0, control="force"), 60)
    norm = [np.mean(info["belief_sd"] ** 6) ** (1.0 / 6.0) for info in (infos[0], infos[-1])]
    expected = 12.0 * np.log(norm[0] / norm[1])
    if reward == "mixed":
        gained = infos[-1]["information_claimed"] - infos[0]["information_claimed"]
        expected = 0.5 * (expected + gained)
    assert rewards.sum() == pytest.approx(expected, abs=1e-9)
    assert expected > 1.0


def test_information_is_that_of_the_belief_in_info():
    env = gym.make(ID, episode_s=1.0, control="force")
    info, prior = play(env, 20)[1][-1], env.unwrapped.prior
    claimed = claimed_information(info["belief_cov"], prior.sd)
    true = true_information(info["truth"], info["belief_mean"], info["belief_cov"], prior.mean, prior.sd)
    assert info["information_claimed"] == pytest.approx(claimed, abs=1e-9)
    assert info["information_true"] == pytest.approx(true, abs=1e-9)
    error = info["belief_mean"] - info["truth"]
    assert info["nees"] == pytest.approx(error @ np.linalg.solve(info["belief_cov"], error), rel=1e-9)
    np.testing.assert_allclose(info["belief_sd"], np.sqrt(np.diag(info["belief_cov"])))


def test_the_bound_is_told_only_when_it_is_tracked():
    _, with_bound = gym.make(ID, track_bound=True, control="force").reset(seed=0)
    _, without = gym.make(ID, control="force").reset(seed=0)
    assert set(with_bound) - set(without) == {"bound_sd", "information_bound"}
    np.testing.assert_allclose(with_bound["bound_sd"], jawenv.cohort("trismus").prior.sd)


def test_discomfort_is_taken_from_the_reward_by_its_weight():
    """cost = sum of the single costs; weight times its integral over the step."""

    def forward(k):
        return np.array([0, 0, 0.6, 0.6], dtype=np.float32)

    free, infos = play(gym.make(ID, episode_s=3.0, control="force"), 60, forward)
    paid, _ = play(gym.make(ID, episode_s=3.0, comfort_weight=2.0, control="force"), 60, forward)
    cost = np.array([info["cost"] for info in infos[1:]])
    np.testing.assert_allclose(free - paid, 2.0 * cost / 20, atol=1e-12)
    assert cost.max() > 0.0
    for info in infos:
        assert info["cost"] == pytest.approx(sum(info[f"cost_{name}"] for name in COMFORT_LIMITS))
        for name in COMFORT_LIMITS:
            assert info[f"cost_{name}"] >= 0.0
            assert info[f"cost_{name}"] == 0.0 or info[f"comfort_{name}"] > 1.0


def test_a_hard_limit_that_is_crossed_ends_the_episode():
    """A device strong and quick enough to overrun its own governor, whose stops are as soft as a sponge."""
    device = {"stop_stiffness_N_m": 1.0, "stop_damping_N_s_m": 1e-3, "brake_N_s_m": 1e-3, "full_scale_N": 10.0}
    env = gym.make(ID, device=device, cohort="healthy", episode_s=10.0, control="force")
    env.reset(seed=1)
    for _ in range(200):
        _, _, terminated, truncated, info = env.step(np.array([1, 1, 0, 0], dtype=np.float32))
        crossed = any(info[f"comfort_{name}"] > getattr(jawenv.Comfort(), f"{name}_hard") for name in COMFORT_LIMITS)
        assert info["violation"] == crossed
        if terminated:
            break
        assert not crossed
    assert terminated and not truncated
    assert info["violation"]
    assert info["cost"] > 0.0


def test_time_left_falls_from_one_to_zero():
    env = gym.make(ID, episode_s=0.5, control_hz=10, control="force")
    observation, info = env.reset(seed=0)
    left, times = [observation[OBSERVATION_LAYOUT["time_left"]][0]], [info["time"]]
    for _ in range(5):
        observation, _, _, truncated, info = env.step(np.zeros(4, dtype=np.float32))
        left.append(observation[OBSERVATION_LAYOUT["time_left"]][0])
        times.append(info["time"])
    assert truncated
    np.testing.assert_allclose(left, [1.0, 0.8, 0.6, 0.4, 0.2, 0.0], atol=1e-7)
    np.testing.assert_allclose(times, np.arange(6) / 10)


@pytest.mark.parametrize("control", ["force", "trajectory", "targets"])
def test_the_observation_reads_nothing_of_the_truth(control):
    env = gym.make(ID, control=control).unwrapped
    env.reset(seed=0)
    for k in range(10):
        seen, *_ = env.step(swing(k))
    truth = env.simulation.worlds["truth"]
    truth[:] = np.frombuffer(bytes([63]) * truth.nbytes, dtype=truth.dtype)
    simulation, row = env.simulation, np.empty_like(seen)
    settings, scratch = simulation.settings[0], simulation.scratches[0]["seeing"]
    parts = simulation.worlds[0]["known"], settings["control"], settings["filter"]
    observe_world(simulation.device[0], simulation.models[0], *parts, scratch, row)
    np.testing.assert_array_equal(row, seen)


@pytest.mark.parametrize("control", ["force", "trajectory"])
def test_the_scales_of_the_observation(control):
    """Against the truth in info and in the world, from which a good estimate differs little."""
    env = gym.make(ID, control=control).unwrapped
    env.reset(seed=6)
    for _ in range(40):
        observation, _, _, _, info = env.step(np.array([0.2, 0.2, 0.1, 0.1], dtype=np.float32))
    part = {name: observation[place] for name, place in OBSERVATION_LAYOUT.items()}
    known, prior = env.simulation.worlds["known"][0], env.prior
    np.testing.assert_allclose(part["belief_mean"], (info["belief_mean"] - prior.mean) / prior.sd, atol=1e-5)
    np.testing.assert_allclose(part["belief_sd"], np.log10(info["belief_sd"] / prior.sd), atol=1e-5)
    np.testing.assert_allclose(part["pose"] * [0.005, 0.005, 0.25, 0.1, 0.1], info["jaw_state"][:5], atol=5e-3)
    ranges = [known["limits"][name] for name in ("opening", "side", "fore_aft")]
    np.testing.assert_allclose(part["jaw_range"] * [0.03, 0.01, 0.01], ranges, rtol=1e-6)
    assert part["jaw"][0] == pytest.approx(info["comfort_opening"], abs=0.05)
    np.testing.assert_allclose(part["force"][:3] * 24.0, known["reading"][:3], rtol=1e-6)
    assert part["force"][2] < 0.0 < part["force"][0], "opening pushes down, and the motors push forward"
    np.testing.assert_allclose(part["motor_thrust"] * world_full_scale(env), known["motors"]["thrust"], rtol=1e-6)
    assert (part["motor_target"] != 0.0).all() == (control == "trajectory")
    for i, name in enumerate(COMFORT_LIMITS):
        if name != "speed":  # instantaneous here, the largest of the step there
            assert 1.0 - part["comfort_margin"][i] == pytest.approx(info[f"comfort_{name}"], abs=0.15), name


def world_full_scale(env):
    return env.simulation.device[0]["full_scale"]
