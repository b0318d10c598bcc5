"""A moving jaw, as the plain filters carry it, and dense derivatives by an independent model."""

import numpy as np
from numpy_model import step, step_with_derivative

import jawenv

DT = 0.01
STATE, PARAMETERS, GAIN = slice(0, 10), slice(10, 22), 22


class Belief:
    """A random mean of a moving jaw, with load-cell samples and their trend."""

    def __init__(self, rng):
        motion = [
            rng.uniform(1e-3, 8e-3),
            rng.uniform(-1e-3, 1e-3),
            rng.uniform(0.1, 0.4),
            *rng.uniform(-0.05, 0.05, 2),
        ]
        motion += [*rng.uniform(-0.02, 0.02, 2), *rng.uniform(-0.5, 0.5, 3)]
        parameters = jawenv.cohort("trismus").draw_log_parameters(rng)
        self.mean = np.concatenate([motion, parameters, [0.01 * rng.normal()]])
        self.trend = np.concatenate([rng.uniform(-8, 8, 3), rng.uniform(-0.1, 0.1, 3)])
        self.samples = self.trend + rng.normal(size=(3, 6)) * [0.5, 0.5, 0.5, 0.02, 0.02, 0.02]


def model_step(jaw, mean, samples, trend, wrench=None):
    """The independent step of the ten states; complex-safe."""
    return step(jaw, mean, samples, trend, DT, wrench)


def jacobians(jaw, belief):
    """Dense F (23, 23) and G (23, 12)."""
    _, by_all = step_with_derivative(jaw, belief.mean, belief.samples, belief.trend, DT)
    F, G = np.eye(23), np.zeros((23, 12))
    F[STATE], G[STATE] = by_all[:, :23], by_all[:, 23:]
    return F, G
