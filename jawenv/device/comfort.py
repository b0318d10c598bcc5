"""Limits of comfort, relative to the patient's own rest pose and painless range.

A used fraction is the quantity over its soft limit; above 1 it costs, at the hard limit (a multiple of the soft one)
the cost is 1 and the episode ends. The numbers are ``comfort_settings``.
"""

from __future__ import annotations

from functools import cache
from typing import Annotated

import numpy as np

from jawenv.kernels.compiled import njit, njit_inlined
from jawenv.kernels.records import Array, record_dtype
from jawenv.kernels.vec3 import add, apply, cross, norm, vector3
from jawenv.mechanics.forces import muscle_pull
from jawenv.mechanics.jaw import Jaw
from jawenv.mechanics.kinematics import contact_point, fossa, rotation

COMFORT_LIMITS = (
    "force",
    "opening",
    "side",
    "fore_aft",
    "condyle_fore_aft",
    "condyle_side",
    "speed",
    "tension",
)
N_LIMITS = len(COMFORT_LIMITS)
FORCE, OPENING, SIDE, FORE_AFT, CONDYLE_FORE_AFT, CONDYLE_SIDE, SPEED, TENSION = range(N_LIMITS)

# Where between the soft (0) and the hard limit (1) the governor begins.
GOVERNOR_ONSET = 0.1


class ComfortRecord:
    """The settings, SI units."""

    force: float
    speed: float
    condyle_side: float
    side: float
    fore_aft: float
    painless_force: float
    painless_range: float
    largest_opening: float
    condyle_back: float
    condyle_free: float
    tension_margin: float
    hard: Annotated[Array, N_LIMITS]  # over the soft limit, in the order of COMFORT_LIMITS


COMFORT = record_dtype(ComfortRecord)


class Limits:
    """One patient's soft limits, SI units."""

    rest_opening: float
    opening: float  # painless range above rest
    path: Annotated[Array, 3]  # forward place of the mouthpiece on the natural path: a + b s + c s^2
    rest_side: float
    side: float
    fore_aft: float
    condyle_middle: float
    condyle_half: float
    rest_condyle_side: float
    end: Annotated[Array, 5]  # pose at the end of the painless range
    tension_margin: float  # a line's soft limit over its tension there
    tension: Annotated[Array, "lines"]  # the soft limits of the true muscles
    force: float  # on the mouthpiece
    speed: float  # of the mouthpiece
    condyle_side: float  # from where the condyles rest
    hard: Annotated[Array, N_LIMITS]  # over the soft limit, in the order of COMFORT_LIMITS
    onset: Annotated[Array, N_LIMITS]  # used fraction at which the governor begins


@cache
def limits_dtype(n_lines: int) -> np.dtype[np.void]:
    """Dtype of ``Limits``.

    The natural path is that of the mouthpiece under a purely vertical pull.
    """
    return record_dtype(Limits, lines=n_lines)


@njit_inlined
def _path_at(limits: Limits, opening):
    """Forward place of the mouthpiece (m) on the natural path, ``opening`` (m) above the rest opening."""
    s = opening / limits.opening
    return limits.path[0] + limits.path[1] * s + limits.path[2] * s * s


@njit_inlined
def excursions(limits: Limits, jaw: Jaw, point):
    """Opening above rest, side (+ left) and fore-aft excursion from the natural path (m) of the mouthpiece."""
    opening = jaw.mouthpiece[2] - point[2] - limits.rest_opening
    return opening, point[1] - limits.rest_side, point[0] - _path_at(limits, opening)


@njit
def set_tension_limits(jaw: Jaw, muscles, limits: Limits, tension):
    """Soft limits ``tension`` (lines) in N of muscles (lines, 2): what they bear at the end of the painless range.

    What is known is where that range ends. So a belief's used fraction hangs on b alone, and F_o cancels.
    """
    q = (limits.end[0], limits.end[1], limits.end[2], limits.end[3], limits.end[4])
    contact, body_to_head = contact_point(jaw, q), rotation(q)
    for i in range(muscles.shape[0]):
        tension[i] = limits.tension_margin * muscle_pull(jaw, muscles, i, contact, body_to_head)[3]


@njit
def used_fractions(jaw: Jaw, muscles, limits: Limits, tension_limits, motion, force, fractions):
    """Fill ``fractions`` (8) for a motion, the lines' (F_o, b) and the magnitude of the force on the mouthpiece.

    ``motion`` as in ``motors.device_wrench``, ``tension_limits`` as in ``set_tension_limits``.
    """
    q, u, lift = motion
    body_to_head = rotation(q)
    contact = add(contact_point(jaw, q), (0.0, 0.0, lift[0]))
    _, slope, _, _ = fossa(jaw, q[0])
    mouthpiece = vector3(jaw.mouthpiece)
    omega = (u[2], u[3], u[4])
    velocity = add((u[0], u[1], slope * u[0] + lift[1]), apply(body_to_head, cross(omega, mouthpiece)))
    opening, side, fore_aft = excursions(limits, jaw, add(contact, apply(body_to_head, mouthpiece)))
    fractions[FORCE] = force / limits.force
    fractions[OPENING] = max(opening, 0.0) / limits.opening
    fractions[SIDE] = abs(side) / limits.side
    fractions[FORE_AFT] = abs(fore_aft) / limits.fore_aft
    fractions[CONDYLE_FORE_AFT] = abs(q[0] - limits.condyle_middle) / limits.condyle_half
    fractions[CONDYLE_SIDE] = abs(q[1] - limits.rest_condyle_side) / limits.condyle_side
    fractions[SPEED] = norm(velocity) / limits.speed
    worst = 0.0
    for i in range(muscles.shape[0]):
        _, _, _, tension = muscle_pull(jaw, muscles, i, contact, body_to_head)
        worst = max(worst, tension / tension_limits[i])
    fractions[TENSION] = worst


@njit
def set_general_limits(comfort: ComfortRecord, limits: Limits):
    """Limits common to all patients: ``limits`` of force, speed and condyles' side, and all hard ones.

    ``comfort`` is a record of dtype ``COMFORT``.
    """
    limits.force, limits.speed, limits.condyle_side = comfort.force, comfort.speed, comfort.condyle_side
    for k in range(N_LIMITS):
        limits.hard[k] = comfort.hard[k]
        limits.onset[k] = 1.0 + GOVERNOR_ONSET * (comfort.hard[k] - 1.0)


@njit
def cost_of(fraction, hard):
    """Cost of one used fraction: 0 up to the soft limit, 1 at the hard limit."""
    return max(0.0, fraction - 1.0) / (hard - 1.0)


__all__ = [
    "COMFORT_LIMITS",
    "GOVERNOR_ONSET",
    "cost_of",
    "limits_dtype",
    "set_general_limits",
    "set_tension_limits",
    "used_fractions",
]
