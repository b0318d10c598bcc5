"""The adapter between Gymnasium's native vector environments and stable-baselines3."""

from typing import Any

import numpy as np
import pytest
from gymnasium.envs.classic_control.cartpole import CartPoleVectorEnv
from gymnasium.vector import AutoresetMode
from point_env import EPISODE_STEPS, PointVectorEnv
from stable_baselines3 import PPO

from jawenv.errors import InputError
from training.run.vec_env import NativeVecEnv


class SameStepCartPole(CartPoleVectorEnv):
    """Gymnasium's native CartPole, which only knows next_step, reset in the step that ends an episode."""

    metadata = CartPoleVectorEnv.metadata | {"autoreset_mode": AutoresetMode.SAME_STEP}

    def step(self, action: np.ndarray) -> Any:
        observation, reward, terminated, truncated, info = super().step(action)
        done = self.prev_done.copy()
        if done.any():
            info = {"final_obs": observation, "_final_obs": done, "final_info": {}, "_final_info": done}
            self.state[:, done] = self.np_random.uniform(self.low, self.high, size=(4, done.sum()))
            self.steps[done] = 0
            self.prev_done[:] = False
            observation = self.state.T.astype(np.float32)
        return observation, reward, terminated, truncated, info


def play(worlds: NativeVecEnv, steps: int, action: Any) -> list[tuple[Any, ...]]:
    worlds.reset()
    return [worlds.step(action(t)) for t in range(steps)]


def test_cartpole_episode_is_reported_at_its_end() -> None:
    worlds = NativeVecEnv(SameStepCartPole(4, max_episode_steps=30))
    worlds.seed(3)
    outcomes = play(worlds, 30, lambda t: np.ones(4, dtype=np.int64))
    lengths = np.zeros(4, dtype=int)
    ends = 0
    for observation, reward, done, infos in outcomes:
        assert reward.dtype == np.float32 and observation.shape == (4, 4)
        lengths += 1
        for i in range(4):
            if not done[i]:
                assert infos[i] == {}
                continue
            ends += 1
            assert infos[i]["episode"]["l"] == lengths[i]
            assert infos[i]["episode"]["r"] == pytest.approx(lengths[i])
            assert not infos[i]["TimeLimit.truncated"]  # pushing right all the time drops the pole
            assert abs(infos[i]["terminal_observation"][2]) > np.radians(12)
            assert abs(observation[i]).max() <= 0.05  # the first observation of the next episode
            lengths[i] = 0
    assert ends >= 8


def test_cartpole_time_limit_is_a_truncation() -> None:
    worlds = NativeVecEnv(SameStepCartPole(3, max_episode_steps=5))
    worlds.seed(0)
    _, _, done, infos = play(worlds, 5, lambda t: np.full(3, t % 2))[-1]
    assert done.all()
    assert all(info["TimeLimit.truncated"] and info["episode"]["l"] == 5 for info in infos)


def test_ppo_learns_cartpole_through_the_adapter() -> None:
    worlds = NativeVecEnv(SameStepCartPole(8))
    model = PPO("MlpPolicy", worlds, n_steps=64, batch_size=128, seed=0, device="cpu", learning_rate=1e-3)
    model.learn(12_000)
    returns = [episode["r"] for episode in model.ep_info_buffer]
    assert np.mean(returns) > 60.0  # a random policy gets 20


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
    for t, (_, rewards, done, _) in enumerate(outcomes):
        _, reward, terminated, _, info = native.step(outward(t))
        np.testing.assert_array_equal(rewards, reward.astype(np.float32))
        last = info["final_info"] if done.any() else info
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
        assert info["terminal_observation"][2] == pytest.approx(1.0)
    assert cost.max() > 0.0


def test_sums_start_anew_after_an_episode() -> None:
    worlds = NativeVecEnv(PointVectorEnv(5, "same_step"))
    worlds.seed(1)
    outcomes = play(worlds, 2 * EPISODE_STEPS, lambda t: np.full((5, 2), 0.1))
    first, second = outcomes[EPISODE_STEPS - 1][3], outcomes[-1][3]
    for a, b in zip(first, second, strict=True):
        assert a["episode"]["l"] == b["episode"]["l"] == EPISODE_STEPS
        assert a["episode"]["r"] != b["episode"]["r"]


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


def test_shared_empty_info_does_not_outlive_its_step() -> None:
    worlds = NativeVecEnv(PointVectorEnv(3, "same_step"))
    worlds.seed(0)
    worlds.reset()
    worlds.step(np.zeros((3, 2)))[3][0]["mark"] = 1
    assert worlds.step(np.zeros((3, 2)))[3] == [{}, {}, {}]


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


def test_other_autoreset_modes_are_refused() -> None:
    with pytest.raises(InputError):
        NativeVecEnv(CartPoleVectorEnv(2))


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
