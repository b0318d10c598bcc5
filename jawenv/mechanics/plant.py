"""A jaw that somebody else's mechanics move: what it is given, and what it gives back.

Axes are those of the anatomy: origin midway between the condyles' centres of the closed jaw, x forward, y left, z up.
Head axes stay with the skull, body axes with the mandible; in the closed jaw they coincide.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import asin, atan2, isfinite
from typing import Any, NamedTuple, Protocol, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError, MissingPackageError, shown
from jawenv.base.named_objects import import_named, is_named, reason
from jawenv.mechanics.kinematics import rotation

__all__ = [
    "BodyMotion",
    "Motion",
    "PatientJaw",
    "Plant",
    "body_motion",
    "checked_motion",
    "motion_at_mouthpiece",
    "plant_of",
]

Array = NDArray[np.float64]
Row: TypeAlias = list[float]
Six: TypeAlias = tuple[float, float, float, float, float, float]
BodyMotion: TypeAlias = tuple[Six, Six]
"""Coordinates and speeds of a free mandible, (q, u) of ``jawenv.mechanics.kinematics``."""

SKEW = 1e-6  # of a rotation that rounding explains
STEEPEST_YAW = 0.99  # sine: the Euler angles end at 1


class Motion(NamedTuple):
    """Place and velocity of the mandible at its mouthpiece."""

    place_m: Any
    """(3,) of the mouthpiece, head axes."""
    rotation: Any
    """(3, 3) body to head axes."""
    velocity_m_s: Any
    """(3,) of the mouthpiece, head axes."""
    angular_velocity_rad_s: Any
    """(3,) body axes."""


_SHAPES = {"place_m": (3,), "rotation": (3, 3), "velocity_m_s": (3,), "angular_velocity_rad_s": (3,)}


@dataclass(frozen=True, eq=False)
class PatientJaw:
    """The patient of an episode, as a model of the jaw needs it, SI units."""

    jaw: Any
    """The true mass, attachments, fossa, teeth, gravity and mouthpiece: a record of dtype ``jaw_dtype``, whose
    fields ``jawenv.mechanics.jaw.Jaw`` names.
    """
    line_names: tuple[str, ...]
    """N names of muscles, one for each line of action; several lines of a muscle share a name."""
    F_o_N: Array
    """(n,) passive tension of each line in the closed jaw."""
    b: Array
    """(n,) its growth with the strain: F_o exp(b (l - l_o) / l_o)."""
    rest: Motion
    """Rest of this patient's midline model."""


@runtime_checkable
class Plant(Protocol):
    """Protocol of an object that can be the ``plant`` of an environment: the mechanics of the true jaw.

    Each episode has a copy of the object. It may have two more names: ``step_s``, for how long (s) the device's wrench
    is held, which divides 10 ms (0.5 ms without it); and ``take_muscles(F_o_N, b)``, which is called in every tick with
    what tissue that creeps or is excited has made of the lines (n,), and without which such a ``reality`` is refused.
    """

    def reset(self, patient: PatientJaw, rng: np.random.Generator) -> Motion:
        """Put the relaxed jaw of a patient at rest.

        Args:
            patient: whose jaw it is.
            rng: the only source of chance, if equal seeds are to give equal episodes.
        """

    def advance(self, wrench: Array, dt: float) -> Motion:
        """Move the jaw on; returns its motion then.

        Args:
            wrench: (6,) force (N) and moment (N m) on the mouthpiece, body axes, which stay as they are.
            dt: s.
        """


def checked_motion(value: object, source: str) -> Motion:
    """A motion with arrays of its own."""
    if not isinstance(value, Motion):
        raise InputError(f"{source} is {shown(value)}; allowed: a jawenv.Motion")
    fields = []
    for (name, shape), given in zip(_SHAPES.items(), value, strict=True):
        try:
            array = np.array(given, dtype=np.float64)
        except (TypeError, ValueError):
            array = np.empty(0)
        if array.shape != shape or not all(map(isfinite, array.ravel().tolist())):
            raise InputError(f"{source}: {name} is {shown(given)}; allowed: finite numbers of shape {shape}")
        fields.append(array)
    R = fields[1].tolist()
    if not _is_rotation(*R):
        raise InputError(f"{source}: rotation is {shown(R)}; allowed: a rotation matrix, body to head axes")
    if abs(R[1][0]) > STEEPEST_YAW:
        raise InputError(f"{source}: rotation has a yaw whose sine is {R[1][0]:.3f}; allowed: {STEEPEST_YAW} at most")
    return Motion(*fields)


def _is_rotation(first: Row, second: Row, third: Row) -> bool:
    """Whether the rows of a matrix are unit vectors, the third the vector product of the others."""
    (a, b, c), (d, e, f), (g, h, i) = first, second, third
    skew = abs(a * a + b * b + c * c - 1.0) + abs(d * d + e * e + f * f - 1.0) + abs(a * d + b * e + c * f)
    return skew + abs(b * f - c * e - g) + abs(c * d - a * f - h) + abs(a * e - b * d - i) < SKEW


def body_motion(motion: Motion, mouthpiece: Array) -> BodyMotion:
    """The twelve numbers of a mandible whose mouthpiece, at ``mouthpiece`` (3,) in body axes, has a checked motion."""
    place, R, velocity, omega = motion
    (a, b, c), (p, q, r) = mouthpiece.tolist(), omega.tolist()
    x, y, z = (place - R @ mouthpiece).tolist()
    vx, vy, vz = (velocity - R @ np.array([q * c - r * b, r * a - p * c, p * b - q * a])).tolist()
    pitch, yaw = atan2(-R[2, 0], R[0, 0]), asin(min(max(R[1, 0], -1.0), 1.0))
    roll = atan2(-R[1, 2], R[1, 1])
    return (x, y, z, pitch, yaw, roll), (vx, vy, vz, p, q, r)


def motion_at_mouthpiece(motion: BodyMotion, mouthpiece: Array) -> Motion:
    """The inverse of ``body_motion``."""
    q, u = motion
    R = np.array(rotation((q[0], q[1], *q[3:])))
    omega = np.array(u[3:])
    return Motion(q[:3] + R @ mouthpiece, R, u[:3] + R @ np.cross(omega, mouthpiece), omega)


def plant_of(spec: object) -> Plant:
    """A plant from itself or from the name ``package.module:Name`` of its class, which is called without arguments."""
    made = spec
    if isinstance(spec, str) and is_named(spec):
        named = import_named(spec, "plant")
        try:
            made = named() if callable(named) else named
        except MissingPackageError:
            raise
        except Exception as error:  # code of the user's can raise anything
            raise InputError(f"plant '{spec}': cannot be made: {reason(error)}") from error
    if not isinstance(made, Plant) or isinstance(made, type):
        raise InputError(
            f"plant is {shown(spec)}; allowed: an object with the methods reset(patient, rng) and "
            "advance(wrench, dt), or package.module:Name of its class"
        )
    return made
