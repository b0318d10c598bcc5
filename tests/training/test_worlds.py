"""The adapter between Gymnasium's native vector environments and stable-baselines3."""

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from point_env import EPISODE_STEPS, PointVectorEnv

from jawenv.base.errors import InputError
from jawenv.sb3 import NativeVecEnv


def play(worlds: NativeVecEnv, steps: int, action: Any) -> list[tuple[Any, ...]]:
    worlds.reset()
    return [worlds.step(action(t)) for t in range(steps)]


def outward(t: int) -> np.ndarray:
    return np.tile([1.0, 0.0], (5, 1)) if t < 3 else np.zeros((5, 2))


def test_episode_figures_belong_to_the_episode_that_ended() -> None:
    worlds = NativeVecEnv(PointVectorEnv(5, "same_step"))
    native = PointVectorEnv(5, "same_step")
    worlds.seed(11)
    native.reset(seed=11)
    cost = np.zeros(5)
    total = np.zeros(5)
    outcomes = play(worlds, EPISODE_STEPS, outward)
    for t, (_, rewards, done, infos) in enumerate(outcomes):
        _, reward, terminated, _, info = native.step(outward(t))
        np.testing.assert_array_equal(rewards, reward.astype(np.float32))
        last = info["final_info"] if done.any() else info
        assert rewards.dtype == np.float32 and (done.any() or infos == [{}] * 5)
        cost += last["cost"]
        total += reward
    assert done.all() and not terminated.any()
    infos = outcomes[-1][3]
    for i, info in enumerate(infos):
        episode = info["episode"]
        assert episode["r"] == pytest.approx(total[i])
        assert episode["cost"] == pytest.approx(cost[i])
        assert episode["information_claimed"] == pytest.approx(total[i])
        assert episode["information_true"] == pytest.approx(0.5 * total[i])
        assert episode["violation"] == 0.0
        assert info["terminal_observation"][2] == pytest.approx(1.0) and outcomes[-1][0][i][2] == 0.0
        assert info["TimeLimit.truncated"] and episode["l"] == EPISODE_STEPS
    assert cost.max() > 0.0


def test_a_monitor_writes_the_figures_of_an_episode(tmp_path: Path) -> None:
    from stable_baselines3.common.vec_env import VecMonitor

    keywords = ("cost", "discomfort_s", "worst_sd", "nees", "time")
    worlds = VecMonitor(NativeVecEnv("jawenv/JawHinge-v3", 2, episode_s=0.6), str(tmp_path / "log"), keywords)
    worlds.reset()
    for _ in range(3):
        infos = worlds.step(np.zeros((2, 4), np.float32))[3]
    worlds.close()
    assert all(key in info and info["episode"][key] == info[key] for info in infos for key in keywords)
    assert infos[0]["time"] == pytest.approx(0.6)


def test_violation_is_a_termination() -> None:
    worlds = NativeVecEnv(PointVectorEnv(2, "same_step", start=1.45))
    worlds.seed(4)
    ended = [info for *_, infos in play(worlds, 10, lambda t: np.ones((2, 2))) for info in infos if info]
    assert ended
    violated = [info for info in ended if info["episode"]["violation"]]
    assert violated and not any(info["TimeLimit.truncated"] for info in violated)


def test_seed_is_used_once() -> None:
    worlds = NativeVecEnv(PointVectorEnv(3, "same_step"))
    worlds.seed(7)
    first, second = worlds.reset(), worlds.reset()
    worlds.seed(7)
    np.testing.assert_array_equal(first, worlds.reset())
    assert not np.array_equal(first, second)


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300])
def test_reward_that_would_ruin_the_network_is_named(value: float, monkeypatch: pytest.MonkeyPatch) -> None:
    worlds = NativeVecEnv(PointVectorEnv(3, "same_step"))
    worlds.seed(0)
    worlds.reset()
    observation, _, terminated, truncated, info = worlds.env.step(np.zeros((3, 2)))
    outcome = (observation, np.array([0.0, value, 0.0]), terminated, truncated, info)
    monkeypatch.setattr(worlds.env, "step", lambda actions: outcome)
    with pytest.raises(InputError):
        worlds.step(np.zeros((3, 2)))


def test_an_id_makes_the_worlds_that_a_refusal_asks_for() -> None:
    with pytest.raises(InputError, match='autoreset_mode="same_step"'):
        NativeVecEnv(gym.make_vec("jawenv/JawHinge-v3", num_envs=2))
    worlds = NativeVecEnv("jawenv/JawHinge-v3", 3, episode_s=1.0, render_mode="rgb_array")
    assert worlds.num_envs == 3 and worlds.env.unwrapped.configuration.episode_s == 1.0
    worlds.seed(0)
    worlds.reset()
    images = worlds.get_images()
    assert len(images) == 3 and len({image.shape for image in images}) == 1
    frame = worlds.render()
    assert frame.ndim == 3 and frame.shape[0] >= images[0].shape[0]
    worlds.close()
    with pytest.raises(InputError, match="num_envs"):
        NativeVecEnv(PointVectorEnv(3, "same_step"), 3)
    assert NativeVecEnv(PointVectorEnv(2, "same_step")).get_images() == [None, None]


def test_what_is_written_to_an_info_stays_that_worlds() -> None:
    worlds = NativeVecEnv(PointVectorEnv(3, "same_step"))
    worlds.seed(0)
    worlds.reset()
    infos = worlds.step(np.zeros((3, 2)))[3]
    infos[0]["mine"] = 1
    assert infos[1:] == [{}, {}]


def test_single_worlds_have_no_methods_or_attributes() -> None:
    worlds = NativeVecEnv(PointVectorEnv(3, "same_step"))
    assert worlds.get_attr("start") == [1.0, 1.0, 1.0]
    assert worlds.env_is_wrapped(object, indices=[0, 2]) == [False, False]
    with pytest.raises(InputError):
        worlds.env_method("render")
    with pytest.raises(InputError):
        worlds.set_attr("start", 2.0)
    worlds.close()
    worlds.close()
