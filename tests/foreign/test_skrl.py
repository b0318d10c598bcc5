"""skrl: PPO on the native vector form, and steps that are the environment's own."""

import gymnasium as gym
import numpy as np
import pytest
from foreign.library import library

import jawenv  # noqa: F401 - registers the environments

pytestmark = [*library("skrl"), pytest.mark.filterwarnings("ignore::DeprecationWarning")]
torch = pytest.importorskip("torch")
pytest.importorskip("skrl")


def test_recipe():
    """PPO on `wrap_env` of the native vector form"""
    from skrl.agents.torch.ppo import PPO, PPO_CFG
    from skrl.envs.wrappers.torch import wrap_env
    from skrl.memories.torch import RandomMemory
    from skrl.trainers.torch import SequentialTrainer
    from skrl.utils.model_instantiators.torch import deterministic_model, gaussian_model

    env = wrap_env(gym.make_vec("jawenv:jawenv/Jaw-v3", num_envs=32, autoreset_mode="same_step", episode_s=3.0))
    network = [{"name": "net", "input": "OBSERVATIONS", "layers": [64, 64], "activations": "tanh"}]
    spaces = {"observation_space": env.observation_space, "action_space": env.action_space, "device": env.device}
    models = {
        "policy": gaussian_model(**spaces, network=network, output="ACTIONS", clip_actions=True),
        "value": deterministic_model(**spaces, network=network, output="ONE"),
    }
    memory = RandomMemory(memory_size=32, num_envs=env.num_envs, device=env.device)
    agent = PPO(models=models, memory=memory, **spaces, cfg=PPO_CFG(rollouts=32))
    SequentialTrainer(env=env, agents=agent, cfg={"timesteps": 64, "headless": True}).train()
    weights = torch.cat([weight.flatten() for weight in models["policy"].parameters()])
    assert torch.isfinite(weights).all() and env.num_envs == 32


def test_steps():
    """`wrap_env` of the native vector form: the same steps, through ends of episodes"""
    from skrl.envs.wrappers.torch import wrap_env

    arguments = {"num_envs": 3, "episode_s": 0.6, "autoreset_mode": "same_step"}
    env, plain = wrap_env(gym.make_vec("jawenv/Jaw-v3", **arguments)), gym.make_vec("jawenv/Jaw-v3", **arguments)
    env._seed = 3
    np.testing.assert_array_equal(env.reset()[0], plain.reset(seed=3)[0])
    for action in np.random.default_rng(0).uniform(-1, 1, (7, 3, 4)).astype(np.float32):
        seen = env.step(torch.as_tensor(action))[:4]
        for one, other in zip(seen, plain.step(action)[:4], strict=True):
            np.testing.assert_allclose(one.numpy().reshape(np.shape(other)), other, rtol=1e-6)
