"""PPO and the pathwise gradient in one file: one policy, two ways to its gradient.

python examples/train_in_one_file.py ppo --updates 100
python examples/train_in_one_file.py apg --updates 20

PPO learns from the rewards of the environment, ``apg`` differentiates the return through its twin (``agents.twin``).
Both correct a maneuver and are judged in the environment: the log of the largest sd after 10 s, less is better.
"""

import argparse

import gymnasium as gym
import numpy as np
import torch
from torch import nn

import jawenv  # registers the environments
from agents.twin.constants import Patients, Twin
from agents.twin.objective import log_worst
from agents.twin.observation import observation
from agents.twin.worlds import Worlds
from jawenv.base.seeds import TRAINING, VALIDATION
from jawenv.playing.maneuvers.maneuver import action_of

EPISODE_S, HZ, COHORT, MANEUVER = 10.0, 5, "one_sided", "refined_one_sided"
STEPS, SCALE, NOISE = round(EPISODE_S * HZ), 0.5, 0.1
GAMMA, LAMBDA, CLIP, EPOCHS, BATCH = 1.0, 0.95, 0.2, 4, 512


def make(worlds: int) -> gym.vector.VectorEnv:
    """Native vector form: all worlds are stepped by one compiled loop."""
    kwargs = {"cohort": COHORT, "reward": "worst", "episode_s": EPISODE_S}
    return gym.make_vec("jawenv/Jaw-v3", num_envs=worlds, autoreset_mode="disabled", **kwargs)


class Policy(nn.Module):
    """Corrections of the maneuver from the observation, and PPO's critic."""

    def __init__(self, inputs: int) -> None:
        super().__init__()
        layers = [nn.Linear(inputs, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh()]
        self.mean = nn.Sequential(*layers, nn.Linear(64, 4))
        self.value = nn.Sequential(nn.Linear(inputs, 64), nn.Tanh(), nn.Linear(64, 1))
        self.base = torch.tensor(jawenv.Maneuver.named(MANEUVER).targets(np.arange(1, STEPS + 1) / HZ).value)
        nn.init.zeros_(self.mean[-1].weight)  # begins as the maneuver
        nn.init.zeros_(self.mean[-1].bias)

    def targets(self, step: int, correction: torch.Tensor) -> torch.Tensor:
        """(P, 4) of the device."""
        return self.base[step] + SCALE * correction.clamp(-1.0, 1.0)

    def distribution(self, seen: torch.Tensor) -> torch.distributions.Normal:
        """Distribution of the corrections (P, 4)."""
        return torch.distributions.Normal(self.mean(seen), NOISE)


def ppo(policy: Policy, env: gym.vector.VectorEnv, optimiser: torch.optim.Optimizer, seed: int) -> None:
    """One episode in each world, then some passes over it with the clipped ratio."""
    seen, _ = env.reset(seed=seed)
    rows, actions, rewards = [], [], []
    with torch.no_grad():
        for step in range(STEPS):
            rows.append(torch.as_tensor(seen))
            actions.append(policy.distribution(rows[-1]).sample())
            action = action_of(policy.targets(step, actions[-1]).numpy())
            seen, reward, _, _, _ = env.step(action.astype(np.float32))
            rewards.append(torch.as_tensor(np.asarray(reward, dtype=np.float32)))
        rows, actions = torch.stack(rows), torch.stack(actions)
        old = policy.distribution(rows).log_prob(actions).sum(-1)
        values = torch.cat([policy.value(rows)[..., 0], torch.zeros(1, env.num_envs)])
        advantage, last = torch.zeros_like(old), torch.zeros(env.num_envs)
        for step in reversed(range(STEPS)):
            last = rewards[step] + GAMMA * values[step + 1] - values[step] + GAMMA * LAMBDA * last
            advantage[step] = last
        returns = (advantage + values[:-1]).flatten()
        advantage = (advantage - advantage.mean(1, keepdim=True)).flatten()  # of the same step: patients differ
        advantage = advantage / (advantage.std() + 1e-8)
        rows, actions, old = rows.flatten(0, 1), actions.flatten(0, 1), old.flatten()
    for _ in range(EPOCHS):
        for chosen in torch.randperm(len(rows)).split(BATCH):
            ratio = (policy.distribution(rows[chosen]).log_prob(actions[chosen]).sum(-1) - old[chosen]).exp()
            gain = torch.minimum(ratio * advantage[chosen], ratio.clamp(1 - CLIP, 1 + CLIP) * advantage[chosen])
            error = policy.value(rows[chosen])[:, 0] - returns[chosen]
            optimiser.zero_grad()
            (0.5 * error.square().mean() - gain.mean()).backward()
            nn.utils.clip_grad_norm_(policy.parameters(), 0.5)
            optimiser.step()


def apg(policy: Policy, env: gym.vector.VectorEnv, optimiser: torch.optim.Optimizer, seed: int) -> None:
    """One episode of new patients in the twin, differentiated as a whole."""
    env.reset(seed=seed)
    simulation = env.unwrapped.simulation
    worlds = Worlds(Twin(simulation), Patients.of_worlds(simulation.worlds), torch.Generator().manual_seed(seed))
    discomfort = torch.zeros(env.num_envs, dtype=torch.float64)
    for step in range(STEPS):
        seen = observation(worlds, 1.0 - step / STEPS, simulation.configuration.parts).float()
        discomfort = discomfort + worlds.step(policy.targets(step, policy.mean(seen).double()))
    optimiser.zero_grad()
    (log_worst(worlds) + 2.0 * discomfort).mean().backward()
    nn.utils.clip_grad_norm_(policy.parameters(), 1.0)
    optimiser.step()


def judge(policy: Policy, worlds: int) -> float:
    """Mean log of the largest sd in the environment, of patients that no update has seen."""
    env = make(worlds)
    seen, info = env.reset(seed=VALIDATION.start)
    with torch.no_grad():
        for step in range(STEPS):
            targets = policy.targets(step, policy.mean(torch.as_tensor(seen)))
            seen, _, _, _, info = env.step(action_of(targets.numpy()).astype(np.float32))
    return float(np.log(info["belief_sd"].max(axis=1)).mean())


def main() -> None:
    """Read the command line, train and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("algorithm", choices=["ppo", "apg"])
    parser.add_argument("--updates", type=int, default=20)
    parser.add_argument("--worlds", type=int, default=64)
    given = parser.parse_args()
    torch.manual_seed(0)
    torch.set_num_threads(1)
    env = make(given.worlds)
    policy = Policy(env.single_observation_space.shape[0])
    optimiser = torch.optim.Adam(policy.parameters(), lr=1e-3)
    update = {"ppo": ppo, "apg": apg}[given.algorithm]
    print(f"the maneuver: {judge(policy, given.worlds):.3f}", flush=True)
    for i in range(given.updates):
        update(policy, env, optimiser, TRAINING.start + i * given.worlds)
    print(f"{given.algorithm} after {given.updates} updates: {judge(policy, given.worlds):.3f}", flush=True)


if __name__ == "__main__":
    main()
