"""An unmodelled wrench with memory: what it is, how the filter carries it, and whether it is honest when told of it."""

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from jawenv.filter.updates.disturbance import set_total
from jawenv.playing.maneuvers import Player

STEPS_PER_S = 5  # of targets control


def play(maneuver, worlds, seconds, seed, **kwargs):
    """The environments, info at the end, and the unmodelled wrench after each step (steps, worlds, 6)."""
    envs = gym.make_vec(
        "jawenv/Jaw-v3", worlds, episode_s=60.0, autoreset_mode=AutoresetMode.DISABLED, **{"cohort": "trismus"} | kwargs
    )
    observations, info = envs.reset(seed=seed)
    player, wrenches = Player(maneuver, control="targets"), []
    player.reset(worlds, 0)
    for _ in range(STEPS_PER_S * seconds):
        actions, _ = player.predict(observations)
        observations, _, _, _, info = envs.step(actions)
        wrenches.append(envs.unwrapped.simulation.worlds["truth"]["unmodelled"].copy())
    return envs, info, np.array(wrenches)


@pytest.mark.parametrize("knowing", ["device", "reality"])
def test_the_wrench_is_an_ornstein_uhlenbeck_process_of_the_devices_sds(knowing):
    _, _, wrenches = play("hold_still", 48, 8, 970_000, **{knowing: {"unmodelled_time_s": 0.5}})
    scaled = wrenches / np.repeat([0.1, 0.003], 3)
    assert np.mean(scaled**2) == pytest.approx(1.0, abs=0.08)
    assert np.mean(scaled[1:] * scaled[:-1]) == pytest.approx(np.exp(-0.2 / 0.5), abs=0.05)
    assert np.mean(scaled[0] ** 2) == pytest.approx(1.0, abs=0.3), "from the first tick on"


def test_without_memory_it_is_new_in_every_tick():
    _, _, wrenches = play("hold_still", 48, 4, 971_000)
    scaled = wrenches / np.repeat([0.1, 0.003], 3)
    assert np.mean(scaled**2) == pytest.approx(1.0, abs=0.08)
    assert np.mean(scaled[1:] * scaled[:-1]) == pytest.approx(0.0, abs=0.05)


def test_motion_and_disturbance_are_one_linear_system(rng):
    motion, total = rng.normal(size=(10, 16)), rng.normal(size=(16, 22))
    set_total(motion, 10, 0.9, 16, total)
    state, wrench, disturbance = rng.normal(size=10), rng.normal(size=6), rng.normal(size=6)
    after = total @ np.concatenate([state, disturbance, wrench])
    np.testing.assert_allclose(after[:10], motion @ np.concatenate([state, wrench + disturbance]), rtol=1e-12)
    np.testing.assert_allclose(after[10:], 0.9 * disturbance, rtol=1e-12)


@pytest.mark.parametrize("time", [0.1, 1.0])
def test_told_of_it_the_filter_is_honest(time):
    _, info, _ = play("refined", 32, 10, 973_000, device={"unmodelled_time_s": time})
    assert 0.7 < np.mean(info["nees"]) / 12 < 1.35
    assert np.max(info["nees"]) / 12 < 4.0
    assert np.mean(info["misfit"] > 1.0) < 0.04


def test_the_bound_has_it():
    device = {"unmodelled_time_s": 1.0}
    bounds = []
    for given in (device, {}):
        _, info, _ = play("refined", 2, 2, 977_000, device=given, track_bound=True)
        bounds.append(info["information_bound"])
    assert np.all(0.0 < bounds[0])
    assert np.all(bounds[0] < 0.85 * bounds[1]), "what lasts is told from a muscle less well than what is white"


def test_untold_the_alarm_rings():
    _, info, _ = play("refined", 16, 10, 974_000, reality={"unmodelled_time_s": 1.0})
    assert np.mean(info["nees"]) / 12 > 10.0
    assert np.mean(info["misfit"] > 1.0) > 0.85


def test_it_goes_with_a_jaw_that_is_known_within_sds():
    _, info, _ = play("refined", 24, 8, 975_000, knowledge="imaged", device={"unmodelled_time_s": 0.5})
    assert 0.7 < np.mean(info["nees"]) / 12 < 1.9
