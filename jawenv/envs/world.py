"""Everything that one simulated world carries from step to step, as one record; an environment is an array of them."""

from __future__ import annotations

import numpy as np

from jawenv.device.comfort import LIMITS_FIELDS, N_LIMITS
from jawenv.device.device import N_MOTORS
from jawenv.estimation.ekf import N_FILTER
from jawenv.mechanics.dynamics import N_STATES
from jawenv.mechanics.jaw import JAW, N_MUSCLES, N_PARAMETERS

LIMITS = np.dtype(LIMITS_FIELDS, align=True)

MOTORS = np.dtype(
    [
        ("thrust", "f8", N_MOTORS),
        ("command", "f8", N_MOTORS),
        ("target", "f8", N_MOTORS),
        ("rate", "f8", N_MOTORS),
        ("cap", "f8", N_MOTORS),
        ("heat", "f8", N_MOTORS),
    ],
    align=True,
)

# The fields down to ``violated`` belong to the truth; the estimator and the agent never read them.
WORLD = np.dtype(
    [
        ("jaw", JAW),
        ("log_parameters", "f8", N_PARAMETERS),
        ("muscles", "f8", (N_MUSCLES, 2)),
        ("cell_gain", "f8"),
        ("state", "f8", N_STATES),
        ("key", "u8", 2),
        ("tick", "i8"),
        ("limits", LIMITS),
        ("motors", MOTORS),
        ("bound", "f8", (N_FILTER, N_FILTER)),
        ("fractions", "f8", N_LIMITS),  # largest used fraction of each limit during the last step
        ("costs", "f8", N_LIMITS),  # mean cost of each limit during the last step
        ("governor", "f8"),  # share of the last step's ticks in which the governor acted
        ("violated", "u1"),
        ("mean", "f8", N_FILTER),
        ("covariance", "f8", (N_FILTER, N_FILTER)),
        ("reading", "f8", 6),  # load cell, body axes
        ("trend", "f8", 6),  # the load cell's recent mean
        ("log_det_prior", "f8"),
        ("log_det", "f8"),
        ("log_det_bound", "f8"),
        ("log_score_prior", "f8"),
        ("log_score", "f8"),
        ("nees", "f8"),
    ],
    align=True,
)


def make_worlds(num_worlds: int) -> np.ndarray:
    """Blank worlds of dtype ``WORLD``; each must be reset before it is advanced."""
    return np.zeros(num_worlds, dtype=WORLD)
