"""Use the environment in work of your own: a patient, a policy and the metrics, with nothing but `pip install jawenv`.

python examples/reuse_environment.py --episode-s 10
"""

import argparse

import gymnasium as gym
import numpy as np

import jawenv
from jawenv.envs.observation import OBSERVATION_LAYOUT


class Sway:
    """A policy of a few lines: all motors open the jaw by a sine, the horizontal ones against each other."""

    control = "force"  # its actions are forces of the motors

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        """Action (N, 4) for observations (N, size), as stable-baselines3's policies give it."""
        gone = 1.0 - observation[..., OBSERVATION_LAYOUT["time_left"]]
        push = 0.2 * np.sin(2.0 * np.pi * 6.0 * gone)
        opening = 0.15 * np.sin(np.pi * gone)
        return np.concatenate([opening, opening, push, -push], axis=-1).astype(np.float32), state


def one_episode(patient: jawenv.Patient, episode_s: float) -> None:
    """The usual loop, with one patient of our own."""
    env = gym.make("jawenv/Jaw-v3", control=Sway.control, episode_s=episode_s)
    policy = Sway()
    observation, info = env.reset(seed=0, options={"patient": patient})
    total, done = 0.0, False
    while not done:
        action, _ = policy.predict(observation)
        observation, reward, terminated, truncated, info = env.step(action)
        total += float(reward)
        done = terminated or truncated
    print(f"{info['time']:g} s, {total:.1f} nats; the left masseter's F_o and b:")
    for i, name in enumerate(env.unwrapped.parameter_names[:2]):
        estimate, sd, truth = np.exp(info["belief_mean"][i]), info["belief_sd"][i], np.exp(info["truth"][i])
        print(f"  {name.removeprefix('log_'):20s} {estimate:.2f} +- {sd:.0%}, truth {truth:.2f}")
    env.close()


def main() -> None:
    """One patient by hand, then sixteen drawn ones at once."""
    parser = argparse.ArgumentParser(description="Use jawenv without training or evaluation code.")
    parser.add_argument("--episode-s", type=float, default=30.0)
    episode_s = parser.parse_args().episode_s

    # Everything stiff alike, but for a left masseter three times as stiff.
    strength = dict.fromkeys(jawenv.MUSCLE_NAMES, 1.0) | {"masseter_left": 3.0}
    one_episode(jawenv.Patient(F_o_N=strength, b=dict.fromkeys(jawenv.MUSCLE_NAMES, 7.0)), episode_s)

    recording = jawenv.play(Sway(), patients=16, seed=0, env_kwargs={"episode_s": episode_s})
    score = jawenv.score(recording)
    print(f"16 drawn patients: {np.mean(score.information_true):.1f} nats, NEES {np.mean(score.nees):.1f}")


if __name__ == "__main__":
    main()
