"""Short records for the tests of estimators, played on the real environment."""

from functools import cache

import numpy as np

import jawenv
from agents import load_agent

SWINGS = "opening_with_swings_and_fore_aft"


class Waves:
    """Each motor pushes in a sine of its own, strongly enough to teach something within seconds."""

    frequencies = np.array([0.9, 0.6, 1.1, 0.7])  # Hz

    def reset(self, num_envs, seed):
        self.time = 0.0

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        self.time += 0.05
        action = 0.35 * np.sin(2.0 * np.pi * self.frequencies * self.time)
        return np.tile(action, (len(observation), 1)).astype(np.float32), state


@cache
def recording(model="jaw", patients=1, seconds=3.0, cohort="trismus"):
    """Quick to play and rich, but it presses the teeth together, unless the jaw hangs open as a healthy one does."""
    kwargs = {"record": True, "model": model, "episode_s": seconds, "cohort": cohort}
    return jawenv.play(Waves(), patients=patients, seed=5000, env_kwargs=kwargs)


@cache
def opening(cohort="trismus"):
    """Eight patients, 30 s of a maneuver that keeps within comfort."""
    agent = load_agent(SWINGS)
    return jawenv.play(agent, patients=8, seed=6000, env_kwargs={"record": True, "cohort": cohort})


def share(record, mean, cov):
    """NEES / 12 of a belief about a record's patient."""
    error = mean - record.truth
    return error @ np.linalg.solve(cov, error) / len(error)
