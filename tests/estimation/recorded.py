"""Short records for the tests of estimators, played on the real environment."""

from functools import cache

import numpy as np

import jawenv


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
def recording(model="jaw", patients=3, seconds=3.0, device=()):
    kwargs = {"record": True, "model": model, "episode_s": seconds, "device": dict(device)}
    return jawenv.play(Waves(), patients=patients, seed=5000, env_kwargs=kwargs)
