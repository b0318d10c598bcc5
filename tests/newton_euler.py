"""The independent jaw of ``jawenv.mechanics.newton_euler``, with its energy and a derivative of any function.

Every function accepts complex numbers, so that complex-step differentiation (Squire & Trapp 1998) gives derivatives
exact to rounding.
"""

import numpy as np

from jawenv.mechanics.newton_euler import (
    acceleration,
    angle_axes,
    contact,
    fossa,
    length,
    measurement,
    muscle_lengths,
    ramp,
    rotation,
    runge_kutta,
    state_rate,
    tensions,
)
from jawenv.references.numpy_model import IMAGINARY_STEP

__all__ = [
    "IMAGINARY_STEP",
    "acceleration",
    "angle_axes",
    "contact",
    "derivative",
    "energy",
    "fossa",
    "length",
    "measurement",
    "muscle_lengths",
    "ramp",
    "ramp_energy",
    "rotation",
    "runge_kutta",
    "state_rate",
    "tensions",
]


def ramp_energy(depth, width):
    """Integral of ``ramp``."""
    if depth.real <= 0.0:
        return 0.0 * depth
    return depth**3 / (6 * width) if depth.real < width else depth**2 / 2 - width * depth / 2 + width**2 / 6


def energy(jaw, log_parameters, q, u):
    """Kinetic energy plus the potentials of weight, muscles, teeth and capsule (J)."""
    R, r = rotation(q), contact(jaw, q)
    rho, omega = jaw["centre_of_mass"], u[2:]
    slope = fossa(jaw, q[0])[1]
    velocity = np.array([u[0], u[1], slope * u[0]]) + R @ np.cross(omega, rho)
    total = 0.5 * jaw["mass"] * velocity @ velocity + 0.5 * omega @ jaw["inertia"] @ omega
    total = total - jaw["mass"] * jaw["gravity"] @ (r + R @ rho)
    total = total + np.sum(tensions(jaw, log_parameters, q) * jaw["l_o"] / np.exp(log_parameters[1::2]))
    total = total + jaw["tone"] * np.sum(muscle_lengths(jaw, q))
    width = jaw["stop_width"]
    for closed in jaw["teeth"]:
        total = total + jaw["tooth_stiffness"] * ramp_energy((r + R @ closed)[2] - closed[2], width)
    capsule = ramp_energy(-q[0], width) + ramp_energy(q[0] - np.pi / jaw["fossa_frequency"], width)
    return total + jaw["condyle_stiffness"] * capsule


def derivative(function, point):
    """Jacobian (n_out, n_in) of ``function``, which takes one point, at the real array ``point``; exact to rounding."""
    columns = []
    for j in range(len(point)):
        moved = np.array(point, dtype=complex)
        moved[j] += 1j * IMAGINARY_STEP
        columns.append(np.imag(function(moved)) / IMAGINARY_STEP)
    return np.column_stack(columns)
