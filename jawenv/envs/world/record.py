"""Everything that one simulated world carries from step to step, as one record; an environment is an array of them."""

from __future__ import annotations

from functools import cache

import numpy as np

from jawenv.device.channels import TRACKER
from jawenv.device.comfort import N_LIMITS, limits_dtype
from jawenv.device.device import N_MOTORS
from jawenv.device.force_sensor import N_ERRORS
from jawenv.filter.bound.bound_recursion import bound_size
from jawenv.filter.state import belief_dtype
from jawenv.kernels.records import record_dtype
from jawenv.mechanics.dynamics import N_STATES
from jawenv.mechanics.jaw import jaw_dtype
from jawenv.reality import reality_state_dtype

MOTORS = record_dtype(
    [
        ("thrust", "f8", N_MOTORS),
        ("command", "f8", N_MOTORS),
        ("target", "f8", N_MOTORS),
        ("rate", "f8", N_MOTORS),
        ("cap", "f8", N_MOTORS),
        ("heat", "f8", N_MOTORS),
    ],
)


@cache
def truth_dtype(n_muscles: int, n_lines: int, n_body: int, n_nuisances: int, n_bound: int) -> np.dtype[np.void]:
    """Dtype of what only the simulation knows: the patient, the motion, what sensors add, and judgements by these."""
    fields = [
        ("jaw", jaw_dtype(n_lines)),
        ("log_parameters", "f8", (2 * n_muscles,)),
        ("muscles", "f8", (n_lines, 2)),
        ("cell_gain", "f8"),
        ("nuisances", "f8", (n_nuisances,)),  # drawn, in prior sds, as ``belief.nuisances`` has them
        ("cell_offset", "f8", 6),
        ("turn", "f8", 3),  # of the mouthpiece about body axes: what the encoders show is turned by it
        ("cell_turn", "f8", 3),  # what the load cell shows is turned by this
        ("no_cell", "u1"),  # whether the force is read without a load cell (``device.force_sensor``)
        ("motor_errors", "f8", (N_MOTORS, N_ERRORS)),  # of that
        ("slack_below", "f8"),  # force of a motor, N
        ("friction_share", "f8", N_MOTORS),  # of Coulomb's friction that acts
        ("motor_rate", "f8", N_MOTORS),  # at the end of the last tick, m/s
        ("state", "f8", N_STATES),
        ("lift", "f8", 2),  # of the condyles' midpoint above its path (m), and its rate (m/s)
        ("body", "f8", (n_body,)),  # of the plant with two condyles
        ("unmodelled", "f8", 6),  # the wrench that no model explains, in this tick
        ("reality", reality_state_dtype(n_lines)),
        ("key", "u8", 2),
        ("acted", "f8"),  # what of the governor acted in the last tick (``device.motors``)
        ("fractions", "f8", N_LIMITS),  # largest used fraction of each limit during the last step
        ("costs", "f8", N_LIMITS),  # mean cost of each limit during the last step
        ("governor", "f8"),  # share of the last step's ticks in which the governor acted
        ("violated", "u1"),
        ("bound", "f8", (n_bound, n_bound)),
        ("log_det_bound", "f8"),
        ("log_score_prior", "f8"),
        ("log_score", "f8"),
        ("nees", "f8"),
    ]
    return record_dtype(fields)


@cache
def known_dtype(n_muscles: int, n_lines: int, n_states: int, n_nuisances: int, n_disturbance: int) -> np.dtype[np.void]:
    """Dtype of what the device knows: its clock and motors, the clinician's limits, its readings and its belief."""
    fields = [
        ("tick", "i8"),
        ("limits", limits_dtype(n_lines)),
        ("motors", MOTORS),
        ("tracker", TRACKER),  # of targets control
        ("reading", "f8", 6),  # load cell, body axes
        ("belief", belief_dtype(n_muscles, n_states, n_lines, n_nuisances, n_disturbance)),
        ("left_out", "f8"),  # share of the last step's readings that were not used
        ("gated", "f8"),  # share of the last step's ticks whose innovation the gate rejected
        ("log_det_prior", "f8"),
        ("log_det", "f8"),
    ]
    return record_dtype(fields)


@cache
def world_dtype(
    n_muscles: int, n_lines: int, n_states: int, n_nuisances: int, n_disturbance: int, n_body: int
) -> np.dtype[np.void]:
    """Dtype of one world. Filter, observation and the law of targets control are given ``known`` alone.

    Args:
        n_muscles: Those with a stiffness of their own.
        n_lines: Lines along which they pull.
        n_states: Of the motion, in the filter's model.
        n_nuisances: What the filter knows within an sd beside the muscles (``filter.nuisances.changes``).
        n_disturbance: Components of the unmodelled wrench that are states of the filter: 6 where it has memory, or 0.
        n_body: States of the plant with two condyles, 0 in a world of another.
    """
    truth = truth_dtype(
        n_muscles, n_lines, n_body, n_nuisances, bound_size(n_muscles, n_states, n_nuisances, n_disturbance)
    )
    known = known_dtype(n_muscles, n_lines, n_states, n_nuisances, n_disturbance)
    return record_dtype([("truth", truth), ("known", known)])
