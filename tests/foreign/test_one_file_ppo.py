"""A PPO of one file, as CleanRL writes it: wrappers, rollout, advantages and updates on a vector environment."""

import gymnasium as gym
import numpy as np
import pytest
from foreign.library import library
from gymnasium import wrappers
from gymnasium.wrappers import vector as vector_wrappers

import jawenv  # noqa: F401 - registers the environments

pytestmark = library("torch")
torch = pytest.importorskip("torch")
WORLDS, STEPS, GAMMA, LAMBDA = 2, 16, 0.99, 0.95


def one_of_many():
    env = wrappers.ClipAction(wrappers.RecordEpisodeStatistics(wrappers.FlattenObservation(made())))
    env = wrappers.TransformObservation(wrappers.NormalizeObservation(env), lambda x: np.clip(x, -10, 10), None)
    return wrappers.TransformReward(wrappers.NormalizeReward(env, gamma=GAMMA), lambda reward: float(reward))


def made():
    return gym.make("jawenv/Jaw-v3", episode_s=1.0)


def native(mode):
    env = gym.make_vec("jawenv/Jaw-v3", WORLDS, episode_s=1.0, autoreset_mode=mode)
    env = vector_wrappers.ClipAction(vector_wrappers.RecordEpisodeStatistics(env))
    if mode == "next_step":  # Gymnasium refuses the other
        env = vector_wrappers.NormalizeObservation(env)
    return vector_wrappers.NormalizeReward(env, gamma=GAMMA)


FORMS = {
    "SyncVectorEnv": lambda: gym.vector.SyncVectorEnv([one_of_many] * WORLDS),
    "native, next_step": lambda: native("next_step"),
    "native, same_step": lambda: native("same_step"),
}


class Agent(torch.nn.Module):
    def __init__(self, inputs, outputs):
        super().__init__()
        self.critic = torch.nn.Sequential(torch.nn.Linear(inputs, 16), torch.nn.Tanh(), torch.nn.Linear(16, 1))
        self.actor = torch.nn.Sequential(torch.nn.Linear(inputs, 16), torch.nn.Tanh(), torch.nn.Linear(16, outputs))
        self.log_sd = torch.nn.Parameter(torch.zeros(outputs))

    def decide(self, observation, action=None):
        chances = torch.distributions.Normal(self.actor(observation), self.log_sd.exp())
        action = chances.sample() if action is None else action
        return action, chances.log_prob(action).sum(1), self.critic(observation).squeeze(1)


def rollout(env, agent, observation, done):
    """Steps and advantages, and the returns of the episodes that ended."""
    rows, returns = [], []
    for _ in range(STEPS):
        with torch.no_grad():
            action, log_chance, value = agent.decide(observation)
        following, reward, terminated, truncated, info = env.step(action.numpy())
        rows.append((observation, action, log_chance, value, torch.as_tensor(reward, dtype=torch.float32), done))
        observation = torch.as_tensor(following, dtype=torch.float32)
        done = torch.as_tensor(terminated | truncated, dtype=torch.float32)
        episode = info.get("final_info", info).get("episode", info.get("episode"))
        if episode is not None:
            returns += np.asarray(episode["r"])[(terminated | truncated)].tolist()
    observations, actions, log_chances, values, rewards, dones = (torch.stack(part) for part in zip(*rows, strict=True))
    with torch.no_grad():
        value = agent.decide(observation)[2]
    advantages, later = torch.zeros_like(rewards), torch.zeros(WORLDS)
    for t in reversed(range(STEPS)):
        alive, next_value = (1 - done, value) if t == STEPS - 1 else (1 - dones[t + 1], values[t + 1])
        later = rewards[t] + GAMMA * next_value * alive - values[t] + GAMMA * LAMBDA * alive * later
        advantages[t] = later
    flat = (part.flatten(0, 1) for part in (observations, actions, log_chances, advantages, advantages + values))
    return tuple(flat), returns, observation, done


@pytest.mark.parametrize("form", FORMS)
def test_ppo(form):
    """A CleanRL-style PPO: `SyncVectorEnv` with single wrappers; native vector form with vector wrappers"""
    torch.manual_seed(0)
    env = FORMS[form]()
    agent = Agent(env.single_observation_space.shape[0], env.single_action_space.shape[0])
    optimiser = torch.optim.Adam(agent.parameters(), lr=1e-3)
    observation, done = torch.as_tensor(env.reset(seed=1)[0], dtype=torch.float32), torch.zeros(WORLDS)
    before, ended = agent.log_sd.detach().clone(), []
    for _ in range(2):
        rows, returns, observation, done = rollout(env, agent, observation, done)
        ended += returns
        observations, actions, log_chances, advantages, targets = rows
        for chosen in torch.randperm(WORLDS * STEPS).split(16):
            _, log_chance, value = agent.decide(observations[chosen], actions[chosen])
            ratio = (log_chance - log_chances[chosen]).exp()
            gain = torch.min(advantages[chosen] * ratio, advantages[chosen] * ratio.clamp(0.8, 1.2)).mean()
            loss = 0.5 * (value - targets[chosen]).square().mean() - gain
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
        assert torch.isfinite(loss)
    assert len(ended) >= 8 and np.isfinite(ended).all()
    assert not torch.equal(agent.log_sd, before)
    env.close()
