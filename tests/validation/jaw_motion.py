"""Motions of jawenv's own equations, and random patients and states for the comparisons."""

import numpy as np

import jawenv
from jawenv.anatomy import default_fossa
from jawenv.kernels.compiled import njit
from jawenv.mechanics.dynamics import state_rate


def motion(jaw, log_parameters, state, wrench, step, n_steps):
    """States (q, u) after each Runge-Kutta step under ``wrench(time)``: (n_steps + 1, 10)."""
    states = np.empty((n_steps + 1, 10))
    states[0] = state
    wrenches = np.array([wrench(i * step / 2) for i in range(2 * n_steps + 1)], dtype=float)
    _fill(jaw, np.exp(log_parameters).reshape(-1, 2), wrenches, step, states)
    return states


@njit
def _rate(jaw, muscles, s, w):
    q, u = (s[0], s[1], s[2], s[3], s[4]), (s[5], s[6], s[7], s[8], s[9])
    q_rate, u_rate = state_rate(jaw, muscles, q, u, (w[0], w[1], w[2], w[3], w[4], w[5]))
    return np.array(q_rate + u_rate)


@njit
def _fill(jaw, muscles, wrenches, step, states):
    for i in range(len(states) - 1):
        s, w = states[i], wrenches[2 * i : 2 * i + 3]
        k1 = _rate(jaw, muscles, s, w[0])
        k2 = _rate(jaw, muscles, s + step / 2 * k1, w[1])
        k3 = _rate(jaw, muscles, s + step / 2 * k2, w[1])
        k4 = _rate(jaw, muscles, s + step * k3, w[2])
        states[i + 1] = s + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def random_state(rng, *, on_stops=False):
    """Coordinates q and speeds u over the whole range of motion; on the stops, teeth or capsule are pressed."""
    crest = default_fossa().crest_m
    x = rng.choice([-1e-3, -0.2e-3, crest + 1e-3]) if on_stops else rng.uniform(0.0, crest)
    theta = rng.uniform(-0.05, 0.0) if on_stops else rng.uniform(0.05, 0.6)
    q = np.array([x, rng.uniform(-3e-3, 3e-3), theta, *rng.uniform(-0.15, 0.15, 2)])
    return q, np.concatenate([rng.uniform(-0.1, 0.1, 2), rng.uniform(-3, 3, 3)])


def random_wrench(rng):
    return np.concatenate([rng.uniform(-20, 20, 3), rng.uniform(-0.5, 0.5, 3)])


def random_patient(rng, cohort=None):
    """Log-parameters of someone of the named or of any cohort."""
    return jawenv.cohort(cohort or rng.choice(list(jawenv.COHORTS))).draw_log_parameters(rng)


def mirror(log_parameters, q, u, wrench):
    """The same jaw in a mirror: muscles change sides, and so do y, yaw, roll and what belongs to them."""
    half = len(log_parameters) // 2
    swapped = np.concatenate([log_parameters[half:], log_parameters[:half]])
    return swapped, q * [1, -1, 1, -1, -1], u * [1, -1, -1, 1, -1], wrench * [1, -1, 1, -1, 1, -1]
