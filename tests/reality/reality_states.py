"""Records for the tests of the effects, and the muscles' lengths from an independent model."""

import newton_euler as twin
import numpy as np

from jawenv.anatomy import cohort
from jawenv.reality import Reality, reality_state_dtype
from jawenv.reality.state import reset_reality
from jawenv.reality.tissue import update_tissue

TICK = 0.01
STILL = (0.0, 0.0, 0.0, 0.0, 0.0)
ON_PATH = (0.0, 0.0)
REST = (3e-3, 0.2e-3, 0.08, 0.01, -0.02)


def drawn_muscles(rng):
    return np.exp(cohort("trismus").draw_log_parameters(rng)).reshape(6, 2)


def tensions(jaw, muscles, q):
    """Independent: (6,) tension of each line under (F_o, b)."""
    return twin.tensions(jaw, np.log(muscles).ravel(), np.asarray(q))


class Tissue:
    """The truth's tissue at rest in ``rest``, moved from pose to pose by ``tick``."""

    def __init__(self, jaw, muscles, rest=REST, normals=None, tick=TICK, **options):
        self.jaw, self.muscles, self.length = jaw, muscles, tick
        self.reality = Reality(**options).records()[0]
        self.state = np.zeros(1, dtype=reality_state_dtype(6))[0]
        for name in self.state.dtype.names:
            self.state[name] = np.nan  # whatever the last episode has left
        normals = np.zeros(6) if normals is None else normals
        reset_reality(self.reality, self.state, jaw, muscles, rest, ON_PATH, np.zeros(12), normals)
        self.effective = np.full((6, 2), np.nan)

    def tick(self, q, u=STILL, lift=ON_PATH):
        """(6,) tension of each line at the start of a tick."""
        update_tissue(
            self.reality, self.state, self.jaw, self.muscles, (tuple(q), tuple(u), lift), self.length, self.effective
        )
        return tensions(self.jaw, self.effective, q)
