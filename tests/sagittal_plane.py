"""Helpers for the tests of the plant in the sagittal plane: the symmetric jaw, its midline motion, its energy."""

import numpy as np
from newton_euler import runge_kutta

from jawenv.mechanics import build_jaw
from jawenv.mechanics.dynamics import linear_dtype, state_rate
from jawenv.mechanics.equilibrium import settle
from jawenv.mechanics.kinematics import fossa, rotation

LAW = (1.5, 7.0)  # F_o (N) and b of every line: opens by some 24 mm under 5 N at the incisors


def flat_jaw():
    """The default jaw with all lines and teeth in the plane y = 0."""
    jaw = build_jaw()
    for name in ("origin", "insertion", "teeth"):
        jaw[name][:, 1] = 0.0
    jaw["l_o"] = np.linalg.norm(jaw["origin"] - jaw["insertion"], axis=1)
    return jaw


def muscles(law=LAW):
    return np.tile(law, (6, 1))


def on_path(jaw, x, theta):
    """State (6) of the plant at rest with its condyle on the midline model's path."""
    return np.array([x, fossa(jaw, x)[0], theta, 0.0, 0.0, 0.0])


def midline_rest(jaw, law=LAW):
    """x and theta where the midline model rests."""
    pose = np.array([3e-3, 0.0, 0.05, 0.0, 0.0])
    scratch = np.zeros(1, dtype=linear_dtype(6))[0]
    _, found = settle(jaw, muscles(law), pose, 0.0, False, scratch, np.empty((5, 5)), np.empty(5))
    assert found
    return pose[0], pose[2]


def midline_opening(jaw, seconds, down_at, tick=0.01, step=2.5e-3):
    """(n, 2) x and theta of the midline model after each tick under the force ``down_at(t)`` (N), from rest."""
    x, theta = midline_rest(jaw)
    state = np.array([x, 0.0, theta, *np.zeros(7)])
    law, rows, substeps = muscles(), [], round(tick / step)
    for i in range(round(seconds / tick) * substeps):

        def rate(since, state, start=i * step):
            down = down_at(start + since)
            wrench = (down * np.sin(state[2]), 0.0, -down * np.cos(state[2]), 0.0, 0.0, 0.0)
            return np.concatenate(state_rate(jaw, law, tuple(state[:5]), tuple(state[5:]), wrench))

        state = runge_kutta(rate, state, step)
        if (i + 1) % substeps == 0:
            rows.append((state[0], state[2]))
    return np.array(rows)


def pulled_down(plant, seconds, down_at, tick=0.01):
    """(n, 6) states of the plant after each tick under the downward force ``down_at(t)`` (N) on the mouthpiece."""
    rows = []
    for i in range(round(seconds / tick)):
        plant.advance(tick, lambda place, velocity, theta, rate, since, t=i * tick: (0.0, -down_at(t + since), 0.0))
        rows.append(plant.state)
    return np.array(rows)


def opening(jaw, states):
    """Opening at the incisors (m) of states (n, 6)."""
    x, _, z = jaw["mouthpiece"]
    return z - (states[:, 1] - x * np.sin(states[:, 2]) + z * np.cos(states[:, 2]))


def energy(jaw, law, state):
    """Kinetic energy, weight's and muscles' potential (J); the muscles' is the integral of F_o exp(b strain) + tone."""
    x, z, theta, x_rate, z_rate, theta_rate = state
    turn, condyle = np.array(rotation((x, 0.0, theta, 0.0, 0.0))), np.array([x, 0.0, z])
    arm = turn @ jaw["centre_of_mass"]
    velocity = np.array([x_rate + theta_rate * arm[2], 0.0, z_rate - theta_rate * arm[0]])
    total = 0.5 * jaw["mass"] * velocity @ velocity + 0.5 * jaw["inertia"][1, 1] * theta_rate**2
    total -= jaw["mass"] * jaw["gravity"] @ (condyle + arm)
    lengths = np.linalg.norm(condyle + jaw["insertion"] @ turn.T - jaw["origin"], axis=1)
    stretched = np.exp(law[:, 1] * (lengths / jaw["l_o"] - 1.0))
    return total + np.sum(law[:, 0] * jaw["l_o"] / law[:, 1] * stretched + jaw["tone"] * lengths)
