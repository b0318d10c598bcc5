"""An agent that reacts to the belief: it moves the jaw to where the least known muscle pulls.

python -m eval compare examples.least_known:LeastKnown refined --patients 16 --output runs/least_known
"""

import numpy as np

from jawenv.envs.observation import OBSERVATION_LAYOUT

HOLD = 4  # control periods until it chooses again
WIDE, NARROW = 0.7, -0.4  # opening that tells b, and one that tells F_o
ASIDE, ROLLED, PUSHED = 0.7, 0.5, 0.5


class LeastKnown:
    """Opens wide for b and little for F_o, to the side and with the push that stretch the least known muscle."""

    name = "least_known"
    control = "targets"

    def reset(self, num_envs, seed=None):
        """Begin at rest."""
        self.step, self.action = 0, np.zeros((num_envs, 4), np.float32)

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        """Action (N, 4) for observations (N, size): opening, side, fore-aft force and roll."""
        rows = np.atleast_2d(observation)
        if self.step % HOLD == 0:
            self.action = self.target(rows)
        self.step += 1
        return self.action.reshape(*observation.shape[:-1], 4).copy(), state

    def target(self, rows):
        """(N, 4) for the parameter with the largest sd: log F_o and log b of each muscle, the left side first."""
        sds = rows[:, OBSERVATION_LAYOUT["belief_sd"]]
        worst, muscles = sds.argmax(axis=1), sds.shape[1] // 2
        muscle, is_b = worst // 2, worst % 2 == 1
        left = muscle < muscles // 2
        temporalis = muscle % (muscles // 2) == 1
        side = np.where(left, -1.0, 1.0)  # a muscle is stretched where the jaw goes to the other side
        opening = np.where(is_b, WIDE, NARROW)
        push = np.where(temporalis, PUSHED, -PUSHED)
        return np.column_stack([opening, ASIDE * side, push, ROLLED * side]).astype(np.float32)
