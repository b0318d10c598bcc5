"""The rate of a jaw's state with its exact derivatives, of the midline model or of the one with two condyles.

Which model it is of follows from the number of coordinates, which is known from the types: the other is not compiled.
"""

from __future__ import annotations

from jawenv.kernels.compiled import njit, njit_within, where
from jawenv.kernels.vec3 import sin_cos
from jawenv.mechanics.bilateral import N_BODY, split_body
from jawenv.mechanics.bilateral_linear import linearise_body
from jawenv.mechanics.dynamics import Linear, linearise_acceleration
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import angle_rates, split


@njit
def _fill_angle_rate_derivatives(q, omega, by_angle):
    """Derivatives of (theta', psi', alpha') by (psi, alpha, omega), into ``by_angle`` (3, 5)."""
    sp, cp = sin_cos(q[3])
    sa, ca = sin_cos(q[4])
    tangent = sp / cp
    across = omega[1] * ca - omega[2] * sa
    along = omega[1] * sa + omega[2] * ca
    by_angle[0, 0], by_angle[0, 1] = across * sp / (cp * cp), -along / cp
    by_angle[0, 2], by_angle[0, 3], by_angle[0, 4] = 0.0, ca / cp, -sa / cp
    by_angle[1, 0], by_angle[1, 1] = 0.0, across
    by_angle[1, 2], by_angle[1, 3], by_angle[1, 4] = 0.0, sa, ca
    by_angle[2, 0], by_angle[2, 1] = -across / (cp * cp), along * tangent
    by_angle[2, 2], by_angle[2, 3], by_angle[2, 4] = 1.0, -ca * tangent, sa * tangent


def _linearise_body(jaw: Jaw, muscles, q, u, wrench, linear: Linear):
    return linearise_body(jaw, muscles, q, u, wrench, linear)


@where(lambda q: len(q) < N_BODY // 2, otherwise=_linearise_body)
def linearise(jaw: Jaw, muscles, q, u, wrench, linear: Linear):
    """``linearise_acceleration`` or ``linearise_body``, whichever is for as many coordinates."""
    return linearise_acceleration(jaw, muscles, q, u, wrench, linear)


@njit_within
def linearised_rate(jaw: Jaw, muscles, q, u, wrench, linear: Linear):
    """(q', u') as two tuples, and into ``linear`` (``linear_dtype``) its derivatives."""
    acceleration = linearise(jaw, muscles, q, u, wrench, linear)
    pose, omega = (q[0], q[1], q[-3], q[-2], q[-1]), (u[-3], u[-2], u[-1])
    _fill_angle_rate_derivatives(pose, omega, linear.by_angle)
    return u[:-3] + angle_rates(pose, omega), acceleration


def _split_body(state, linear: Linear):
    return split_body(state)


@where(lambda linear: linear.typeof("by_state").shape[1] < N_BODY, otherwise=_split_body)
def motion_of(state, linear: Linear):
    """``state`` (10 or 12 numbers) as the tuples q and u of the model that ``linear`` is made for."""
    return split(state)
