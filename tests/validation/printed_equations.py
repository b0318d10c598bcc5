"""Equations of Young (2016) as printed, what they should be, and how far off they are.

The true values come from MuJoCo's body or from differentiating the path numerically, never from jawenv. The states are
of therapy size: mouth opened by 9-36 mm, condyle 1-10 mm forward, at most 0.2 rad/s and 20 mm/s. Each equation
is taken with everything right but the fault in question, in body axes where it mixes axes.

``python tests/validation/printed_equations.py`` prints the table.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from mujoco_twin import MujocoTwin

import jawenv

N_STATES = 300


class Row(NamedTuple):
    """Errors of one equation over the states; ``corrected`` is the largest error of the right form."""

    equation: str
    fault: str
    unit: str
    median: float
    largest: float
    corrected: float


@dataclass
class State:
    """A moving jaw under load, and what MuJoCo knows of it; vectors in body axes unless named otherwise."""

    twin: MujocoTwin
    q: np.ndarray
    u: np.ndarray
    log_parameters: np.ndarray
    wrench: np.ndarray

    def __post_init__(self):
        twin = self.twin
        state = twin.state(self.q, self.u)
        rate = twin.acceleration(state, self.log_parameters, self.wrench)
        reaction = twin.reaction(state, rate, self.log_parameters, self.wrench)
        self.normal_head = reaction[:3] / np.linalg.norm(reaction[:3])
        twin.move(state)
        self.R = twin.body_to_head()
        self.mouthpiece_head = twin.place(twin.mouthpiece)
        self.M = twin.mass_matrix()
        self.omega, self.omega_rate = self.u[2:], rate[2:]
        slope, curvature = twin.height(self.q[0])[1:]
        self.contact_rate = self.R.T @ twin.velocity(twin.contact)
        self.contact_rate2 = self.R.T @ [rate[0], rate[1], slope * rate[0] + curvature * self.u[0] ** 2]
        self.centre_rate = self.R.T @ twin.velocity(twin.centre)
        # What eq. 4.18 counts, muscles and device: places from o and forces in head axes.
        acting, sites = dict(twin.pushes(self.log_parameters, self.wrench)), (*twin.insertions, twin.mouthpiece)
        self.pushes = [(twin.place(site), acting[site]) for site in sites]
        moments = [(twin.jacobians(site)[0].T @ acting[site])[3:] for site in sites]
        self.muscle_moment = np.linalg.norm(sum(moments[:-1]))
        self.moment = sum(moments)
        # With damping and, from the bias forces of the jaw at rest, weight.
        self.full_moment = twin.applied(self.log_parameters, self.wrench)[3:]
        twin.move(twin.state(self.q, 0 * self.u))
        self.full_moment = self.full_moment - twin.data.qfrc_bias[3:]


def therapy_states(cohort="trismus", speed=1.0, seed=2016):
    """Random states of therapy size; ``speed`` scales the rates."""
    rng, twin = np.random.default_rng(seed), MujocoTwin()
    for _ in range(N_STATES):
        q = np.array([rng.uniform(1e-3, 10e-3), rng.uniform(-1e-3, 1e-3), rng.uniform(0.1, 0.4), 0.0, 0.0])
        q[3:] = rng.uniform(-0.05, 0.05, 2)
        u = np.array([rng.choice([-1, 1]) * rng.uniform(5e-3, 20e-3), rng.uniform(-5e-3, 5e-3), 0.0, 0.0, 0.0])
        u[2:] = rng.uniform(-1, 1, 3) * [0.1, 0.2, 0.1]
        pull = np.array([rng.uniform(-1, 1), rng.uniform(-1, 1), -rng.uniform(1, 8), 0, 0, 0])
        yield State(twin, q, speed * u, jawenv.cohort(cohort).draw_log_parameters(rng), pull)


def cross_matrix(r):
    """[r x]."""
    return np.cross(r, np.eye(3)).T


def path(twin, x):
    """Height of the fossa at x, real or complex."""
    return twin.fossa.drop_m * (np.cos(twin.fossa.spatial_frequency * x) - 1)


def orientation(s):
    """Eq. 4.6: C takes inertial to body axes in eq. 4.11, here it should do the reverse."""
    arm, contact = s.twin.mandible.mouthpiece_m, np.array([*s.q[:2], path(s.twin, s.q[0])])
    truth, size = s.mouthpiece_head, np.linalg.norm(arm)
    return contact + s.R.T @ arm - truth, contact + s.R @ arm - truth, size


def sliding_velocity(s):
    """Eq. 4.7: x' - d f sin(f x) for the vertical part, which should be a product."""
    d, f = s.twin.fossa.drop_m, s.twin.fossa.spatial_frequency
    x, forward = s.q[0], s.u[0]
    truth = path(s.twin, x + 1e-30j * forward).imag / 1e-30
    size = np.hypot(np.hypot(forward, s.u[1]), truth)
    return forward - d * f * np.sin(f * x) - truth, -d * f * forward * np.sin(f * x) - truth, size


def moment_arms(s):
    """Eqs. 4.18, 4.20, 4.23, 4.25: moments about the contact point, with arms from o."""
    contact = np.array([*s.q[:2], path(s.twin, s.q[0])])
    printed = s.R.T @ sum(np.cross(place, force) for place, force in s.pushes)
    right = s.R.T @ sum(np.cross(place - contact, force) for place, force in s.pushes)
    return printed - s.moment, right - s.moment, s.muscle_moment


def weight_and_damping(s):
    """Eqs. 4.18, 4.25, 4.27: no weight, and no damping c omega although section 4.3 announces it."""
    m, rho = s.twin.mandible.mass_kg, s.twin.mandible.centre_of_mass_m
    right = s.moment + np.cross(rho, m * s.R.T @ s.twin.gravity) - s.twin.mandible.damping_rotation * s.omega
    return s.moment - s.full_moment, right - s.full_moment, s.muscle_moment


def angular_momentum(s):
    """Eqs. 4.21-4.25: omega x (r x v) for the derivative of r x v adds m r x (omega x v)."""
    mandible = s.twin.mandible
    m, I, rho, omega = mandible.mass_kg, mandible.inertia_kg_m2, mandible.centre_of_mass_m, s.omega
    A = I - m * cross_matrix(rho) @ cross_matrix(rho)
    centripetal = np.cross(omega, np.cross(omega, rho))
    right = s.full_moment - np.cross(omega, I @ omega) - m * np.cross(rho, s.contact_rate2 + centripetal)
    printed = right + m * np.cross(s.centre_rate, s.contact_rate)
    printed = printed - m * np.cross(omega, np.cross(rho, s.centre_rate))
    return printed - A @ s.omega_rate, right - A @ s.omega_rate, s.muscle_moment


def normal(s):
    """Eq. 4.28: perpendicular to the position of the contact point, not to the surface."""
    d, f = s.twin.fossa.drop_m, s.twin.fossa.spatial_frequency
    x = s.q[0]
    printed = np.array([-path(s.twin, x), 0, x])
    right = np.array([d * f * np.sin(f * x), 0, 1])

    def angle(direction):
        return np.degrees(np.arcsin(np.linalg.norm(np.cross(direction, s.normal_head)) / np.linalg.norm(direction)))

    return angle(printed), angle(right), 1.0


def inertia_of_contact(s):
    """Eq. 4.29: Q = 1 + m A^-1 [r x][r x] should be 1 + m [r x] A^-1 [r x]."""
    m, rho = s.twin.mandible.mass_kg, s.twin.mandible.centre_of_mass_m
    linear, coupling, A = s.R.T @ s.M[:3, :3] @ s.R, s.R.T @ s.M[:3, 3:], s.M[3:, 3:]
    truth = (linear - coupling @ np.linalg.solve(A, coupling.T)) / m
    r = cross_matrix(rho)
    printed, right = np.eye(3) + m * np.linalg.solve(A, r @ r), np.eye(3) + m * r @ np.linalg.solve(A, r)
    return printed - truth, right - truth, np.linalg.norm(truth)


def curvature(s):
    """Eq. 4.31: x' not squared in the vertical acceleration of steady sliding."""
    d, f = s.twin.fossa.drop_m, s.twin.fossa.spatial_frequency
    x, forward, dt = s.q[0], s.u[0], 1e-3
    climbing = [path(s.twin, x + forward * t + 1e-30j * forward).imag / 1e-30 for t in (-2 * dt, -dt, dt, 2 * dt)]
    truth = (climbing[0] - 8 * climbing[1] + 8 * climbing[2] - climbing[3]) / (12 * dt)
    bend = -(f**2) * d * np.cos(f * x)
    # Relative to the largest that this speed can give: the term itself vanishes half way to the crest.
    return bend * forward - truth, bend * forward**2 - truth, f**2 * d * forward**2


HEALTHY, FAST = {"cohort": "healthy"}, {"speed": 10.0}

CHECKS = (
    ("4.6", "C for its transpose: place of the mouthpiece", "of the arm", orientation, {}),
    ("4.7", "a factor became a term: vertical velocity", "of the speed", sliding_velocity, {}),
    ("4.18, 4.25", "arms from o: moment", "of the muscles' moment", moment_arms, {}),
    ("4.25, trismus", "no weight, no damping: moment", "of the muscles' moment", weight_and_damping, {}),
    ("4.25, healthy", "no weight, no damping: moment", "of the muscles' moment", weight_and_damping, HEALTHY),
    ("4.21", "derivative of r x v: moment", "of the muscles' moment", angular_momentum, {}),
    ("4.21, 10 x faster", "derivative of r x v: moment", "of the muscles' moment", angular_momentum, FAST),
    ("4.28", "normal to the position, not to the surface", "degrees", normal, {}),
    ("4.29", "order of factors: inertia of the contact point", "of Q", inertia_of_contact, {}),
    ("4.31", "x' not squared: vertical acceleration", "of f^2 d x'^2", curvature, {}),
)


def errors_of_printed_equations():
    """A `Row` per printed equation; the vector or matrix in question is compared by its norm."""
    rows = []
    for equation, fault, unit, check, population in CHECKS:
        errors = []
        for state in therapy_states(**population):
            printed, right, size = check(state)
            errors.append((np.linalg.norm(printed) / size, np.linalg.norm(right) / size))
        printed, right = np.array(errors).T
        rows.append(Row(equation, fault, unit, float(np.median(printed)), float(printed.max()), float(right.max())))
    return rows


def table(rows):
    """The rows as text."""
    lines = [f"{'Young (2016), eq.':<18} {'fault':<48} {'median':>8} {'largest':>8} {'corrected':>9}  unit"]
    for row in rows:
        numbers = f"{row.median:8.3g} {row.largest:8.3g} {row.corrected:9.1e}"
        lines.append(f"{row.equation:<18} {row.fault:<48} {numbers}  {row.unit}")
    return "\n".join(lines)


if __name__ == "__main__":
    print(table(errors_of_printed_equations()))
