"""Comfort of one's own: soft and hard limits of another clinician, in cost, governor, observation and law."""

import gymnasium as gym
import numpy as np
import pytest

import jawenv
from jawenv.device.channels import FORE_AFT
from jawenv.device.comfort import GOVERNOR_ONSET
from jawenv.envs.world.tracking import wanted_by

ID = "jawenv/Jaw-v3"
PUSH = np.array([0.15, 0.15, 0.05, 0.05], np.float32)
BARELY = np.array([0.03, 0.03, 0.01, 0.0], np.float32)


def played(steps=20, action=PUSH, **arguments):
    """Observation and info of each step of a single environment, and the environment."""
    env = gym.make(ID, **{"control": "force", **arguments}).unwrapped
    env.reset(seed=5000)
    seen = []
    while len(seen) < steps and not (seen and seen[-1][2]):  # until a hard limit is crossed
        seen.append(env.step(action))
    return [step[0] for step in seen], [step[4] for step in seen], env


def test_the_default_given_is_the_default(tmp_path):
    (tmp_path / "comfort.toml").write_text("force_N = 24\n")
    wanted, _, _ = played()
    for given in (jawenv.Comfort(), {}, {"speed_mm_s": 40}, tmp_path / "comfort.toml"):
        np.testing.assert_array_equal(played(comfort=given)[0], wanted)


def test_used_fractions_are_of_the_own_limits():
    """The governor acts at neither; the jaw moves alike."""
    _, default, _ = played(action=BARELY)
    comfort = jawenv.Comfort(force_N=48.0, speed_mm_s=80.0, tension_margin=3.0, side_mm=20.0)
    _, own, _ = played(action=BARELY, comfort=comfort)
    for k in range(20):
        assert default[k]["governor"] == own[k]["governor"] == 0.0
        for name in ("force", "speed", "tension", "side"):
            assert own[k][f"comfort_{name}"] == pytest.approx(0.5 * default[k][f"comfort_{name}"], rel=1e-9), name
        assert own[k]["comfort_opening"] == default[k]["comfort_opening"]


def test_ranges_are_of_the_own_painless_pull():
    observations, _, _ = played(steps=1)
    short, _, env = played(steps=1, comfort={"painless_range_mm": 8.0})
    soft, weak = played(steps=1, comfort={"painless_force_N": 15.0})[2], played(steps=1)[2]
    opening = [each.simulation.worlds["known"]["limits"]["opening"][0] for each in (env, soft, weak)]
    assert 7.5e-3 < opening[0] < 8e-3 and opening[1] < opening[2]  # counted from rest, a little open
    assert short[0][37] == pytest.approx(opening[0] / 0.03, rel=1e-5) and observations[0][37] > short[0][37]


def test_the_cost_is_one_at_the_own_hard_limit_and_the_episode_ends_there():
    _, infos, _ = played(steps=40, comfort={"tension_margin": 0.25, "tension_hard": 1.5})
    crossed = next(k for k, info in enumerate(infos) if info["violation"])
    assert infos[crossed]["comfort_tension"] > 1.5 and not any(info["violation"] for info in infos[:crossed])
    _, single, _ = played(steps=3, control_hz=100.0, comfort={"tension_margin": 0.3, "tension_hard": 5.0})
    for info in single:  # one tick in a step
        assert info["cost_tension"] == pytest.approx(max(0.0, info["comfort_tension"] - 1.0) / 4.0)


def test_the_governor_caps_the_own_force():
    """Before a stop is reached, and without a brake."""
    comfort, device = jawenv.Comfort(force_N=1.0, force_hard=3.0), {"brake_N_s_m": 0.0}
    _, infos, _ = played(action=np.array([0.5, 0.5, 0.0, 0.0], np.float32), steps=3, comfort=comfort, device=device)
    assert infos[-1]["comfort_force"] == pytest.approx(1.0 + GOVERNOR_ONSET * 2.0)
    assert infos[-1]["governor"] > 0.0


def test_the_fore_aft_target_is_a_share_of_the_own_force():
    env = gym.make(ID, comfort={"force_N": 6.0}).unwrapped
    env.reset(seed=5000)
    observation, *_ = env.step(np.array([-1.0, 0.0, 0.1, 0.0], np.float32))
    tracker = env.simulation.worlds["known"]["tracker"][0]
    share = tracker["size"][FORE_AFT] * tracker["target"][FORE_AFT]
    assert wanted_by(observation[24:], tracker).forward == pytest.approx(6.0 * share) and share > 0.05


@pytest.mark.parametrize(
    "given", [{"force_N": 0.0}, {"speed_hard": 1.0}, {"painless_range_mm": 4.0}, {"force": 3.0}, "strict", 3]
)
def test_what_is_not_allowed_is_one_line(given):
    with pytest.raises(jawenv.InputError):
        gym.make(ID, comfort=given)
