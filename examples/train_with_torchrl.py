"""Train a policy with TorchRL on the native vector form: PPO's clipped loss in one file.

pip install jawenv torchrl
python examples/train_with_torchrl.py --steps 100000
"""

import argparse

import gymnasium as gym
import torch
from tensordict.nn import TensorDictModule
from tensordict.nn.distributions import NormalParamExtractor
from torch import nn
from torchrl.envs import GymWrapper
from torchrl.modules import ProbabilisticActor, TanhNormal, ValueOperator
from torchrl.objectives import ClipPPOLoss
from torchrl.objectives.value import GAE

import jawenv  # noqa: F401 - registers the environments
from jawenv.base.seeds import TRAINING

WORLDS, STEPS_EACH, EPOCHS, BATCH = 32, 64, 4, 512
KWARGS = {"reward": "mixed", "comfort_weight": 60.0}


def networks(env: GymWrapper) -> tuple[ProbabilisticActor, ValueOperator]:
    """A policy and its critic, of two layers each."""

    def layers(outputs: int, *more: nn.Module) -> nn.Sequential:
        inputs = env.observation_spec["observation"].shape[-1]
        return nn.Sequential(
            nn.Linear(inputs, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh(), nn.Linear(64, outputs), *more
        )

    actions = env.action_spec.shape[-1]
    body = TensorDictModule(layers(2 * actions, NormalParamExtractor()), ["observation"], ["loc", "scale"])
    actor = ProbabilisticActor(
        body, in_keys=["loc", "scale"], spec=env.action_spec, distribution_class=TanhNormal, return_log_prob=True
    )
    return actor, ValueOperator(layers(1), in_keys=["observation"])


def train(steps: int, episode_s: float) -> None:
    """Collect, improve, and print the mean reward of each round, nats a step."""
    torch.manual_seed(0)
    torch.set_num_threads(1)
    worlds = gym.make_vec("jawenv/Jaw-v3", num_envs=WORLDS, autoreset_mode="disabled", episode_s=episode_s, **KWARGS)
    env = GymWrapper(worlds)
    env.set_seed(TRAINING.start)
    actor, critic = networks(env)
    advantage = GAE(gamma=0.97, lmbda=0.95, value_network=critic)
    loss = ClipPPOLoss(actor, critic, entropy_coeff=1e-3)
    optimiser = torch.optim.Adam(loss.parameters(), lr=3e-4)
    for i in range(max(1, steps // (WORLDS * STEPS_EACH))):
        with torch.no_grad():
            played = env.rollout(STEPS_EACH, actor, break_when_any_done=False)
            advantage(played)
        rows = played.reshape(-1)
        for _ in range(EPOCHS):
            for chosen in torch.randperm(len(rows)).split(BATCH):
                parts = loss(rows[chosen])
                optimiser.zero_grad()
                sum(value for name, value in parts.items() if name.startswith("loss_")).backward()
                optimiser.step()
        print(f"round {i + 1}: {played['next', 'reward'].mean():.3f} nats a step", flush=True)


def main() -> None:
    """Read the command line and train."""
    parser = argparse.ArgumentParser(description="Train with TorchRL.")
    parser.add_argument("--steps", type=int, default=100_000)
    parser.add_argument("--episode-s", type=float, default=30.0)
    given = parser.parse_args()
    train(given.steps, given.episode_s)


if __name__ == "__main__":
    main()
