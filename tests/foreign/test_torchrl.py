"""TorchRL: its checker of specs, and rollouts that are the environment's own numbers."""

import gymnasium as gym
import numpy as np
import pytest
from foreign.library import ids_and_controls, library

import jawenv  # noqa: F401 - registers the environments

# TorchRL's and its dependencies' own: what they import or call is out of date in other packages.
pytestmark = [*library("torchrl"), pytest.mark.filterwarnings("ignore::DeprecationWarning")]
torch = pytest.importorskip("torch")
envs = pytest.importorskip("torchrl.envs", exc_type=ImportError)


@pytest.mark.parametrize(("env_id", "control"), ids_and_controls())
def test_check_env_specs(env_id, control):
    """`check_env_specs(GymEnv(...))`: every id and control mode"""
    envs.check_env_specs(envs.GymEnv(env_id, control=control, episode_s=1.0), seed=0)


def test_pixels():
    """`GymEnv(..., from_pixels=True)`"""
    envs.check_env_specs(envs.GymEnv("jawenv/Jaw-v3", from_pixels=True, pixels_only=False, episode_s=0.6), seed=0)


@pytest.mark.parametrize("mode", ["same_step", "disabled"])
def test_native_vector_form(mode):
    """`GymWrapper` of the native vector form: specs, a rollout through ends of episodes (same_step, disabled)"""
    arguments = {"num_envs": 3, "episode_s": 1.0, "autoreset_mode": mode}
    env = envs.GymWrapper(gym.make_vec("jawenv/Jaw-v3", **arguments))
    assert env.batch_size == torch.Size([3])
    envs.check_env_specs(env, seed=0)
    env = envs.GymWrapper(gym.make_vec("jawenv/Jaw-v3", **arguments))
    env.set_seed(3)
    seen = env.rollout(12, break_when_any_done=False)
    done = seen["next", "done"].squeeze(-1).numpy()
    np.testing.assert_array_equal(done.sum(axis=1), 2)
    plain = gym.make_vec("jawenv/Jaw-v3", **arguments)
    plain.reset(seed=3)
    np.testing.assert_array_equal(plain.reset()[0], seen["observation"][:, 0])  # a seed is for the episode before
    rewards = [plain.step(action)[1] for action in seen["action"].numpy().transpose(1, 0, 2)[:5]]
    np.testing.assert_allclose(seen["next", "reward"].squeeze(-1).numpy()[:, :5].T, rewards, rtol=1e-6)


def test_next_step_autoreset_is_refused():
    """TorchRL takes no vector environment that begins anew in the step after the end (next_step)"""
    with pytest.raises(RuntimeError, match="must be one of SAME_STEP or DISABLED"):
        envs.GymWrapper(gym.make_vec("jawenv/Jaw-v3", num_envs=2))
