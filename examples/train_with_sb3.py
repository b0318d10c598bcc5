"""Train PPO of stable-baselines3 on the native vector form, and compare it with a maneuver, from the wheel alone.

pip install "jawenv[sb3]"
python examples/train_with_sb3.py --steps 200000
"""

import argparse
import sys

import numpy as np
import torch
from stable_baselines3 import PPO

import jawenv
from jawenv.base.seeds import TRAINING
from jawenv.sb3 import NativeVecEnv

ENV_ID = "jawenv/Jaw-v3"
WORLDS, STEPS_EACH = 32, 128
MANEUVER = "slow_opening"


def trained(steps: int, episode_s: float) -> PPO:
    """A policy after so many steps; a penalty in the reward keeps it comfortable."""
    torch.set_num_threads(1)  # more threads wait for each other and for the environment
    kwargs = {"episode_s": episode_s, "reward": "mixed", "comfort_weight": 60.0}
    worlds = NativeVecEnv(ENV_ID, WORLDS, **kwargs)
    worlds.seed(TRAINING.start)
    model = PPO("MlpPolicy", worlds, n_steps=STEPS_EACH, batch_size=1024, gamma=0.97, seed=0, device="cpu")
    model.learn(steps)
    worlds.close()
    return model


def judged(name: str, agent: object, patients: int, episode_s: float) -> None:
    """Print what an agent finds out about patients of the test, and at which discomfort."""
    score = jawenv.score(jawenv.play(agent, patients=patients, seed=0, env_kwargs={"episode_s": episode_s}))
    worst = np.median(score.sd.max(axis=1))
    print(f"{name:14s} worst parameter within {worst:6.1%}, discomfort {score.discomfort_s.mean():.2f} s", flush=True)


def main() -> None:
    """Read the command line, train and compare."""
    parser = argparse.ArgumentParser(description="Train with stable-baselines3.")
    parser.add_argument("--steps", type=int, default=200_000)
    parser.add_argument("--patients", type=int, default=32)
    parser.add_argument("--episode-s", type=float, default=30.0)
    given = parser.parse_args()
    for name in ("steps", "patients"):
        if getattr(given, name) < 1:
            raise jawenv.InputError(f"{name} is {getattr(given, name)}; allowed: 1 or more")
    judged("PPO", trained(given.steps, given.episode_s), given.patients, given.episode_s)
    judged(MANEUVER, jawenv.Player(MANEUVER, control="targets"), given.patients, given.episode_s)


if __name__ == "__main__":
    try:
        main()
    except jawenv.InputError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
