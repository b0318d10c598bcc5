"""An agent of your own: a class with a name, `reset` and `predict`, wherever an agent is asked for.

python -m eval compare examples.careful_agent:Careful hold_still --patients 16 --output runs/careful
"""

import numpy as np

from jawenv.envs.observation import OBSERVATION_LAYOUT

OPENINGS = 4  # in an episode


class Careful:
    """Opens to half of the patient's painless range and shuts again, slowly."""

    name = "careful"
    control = "targets"  # what its actions mean

    def reset(self, num_envs, seed=None):
        """Nothing to forget: the observation says how much time is left."""

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        """Action (N, 4) for observations (N, size): opening, side, fore-aft force and roll."""
        gone = 1.0 - observation[..., OBSERVATION_LAYOUT["time_left"]]
        action = np.zeros((*observation.shape[:-1], 4), np.float32)
        action[..., :1] = -0.5 * (1.0 + np.cos(2.0 * np.pi * OPENINGS * gone))  # -1 is the rest pose, 0 half the range
        return action, state
