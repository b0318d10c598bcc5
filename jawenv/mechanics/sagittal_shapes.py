"""Shapes of condyle and fossa in pymunk's space, in mm."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jawenv.base.extras import needs

with needs("JawSagittal", "pymunk", "sagittal"):
    import pymunk

MM = 1e3
# mm of overlap that contact rests on. Without it a contact is lost in every other step and the body falls back onto
# the fossa with the speed of one step's free fall.
SLOP = 0.01
CONDYLE, FOSSA = 1, 2
WALL = 15.0  # mm that the walls at both ends reach down
END = 1.5  # crests from the roof to the front wall


def _fossa_outline(jaw: Any, radius: float, segment: float) -> NDArray[np.float64]:
    """(n, 2) corners of the fossa (mm), from the foot of the posterior wall to that of the anterior one.

    Between the walls they lie on the parallel curve of the condyle centre's path. The condyle rests on it with an
    overlap of the slop, so the distance is its radius less that.
    """
    distance = MM * radius - SLOP
    d, f = MM * float(jaw["fossa_drop"]), float(jaw["fossa_frequency"]) / MM
    end = END * np.pi / f
    x = np.linspace(0.0, end, round(end / (MM * segment)) + 1)
    slope = -d * f * np.sin(f * x)
    normal = np.column_stack([-slope, np.ones_like(x)]) / np.hypot(1.0, slope)[:, None]
    curve = np.column_stack([x, d * (np.cos(f * x) - 1.0)]) + distance * normal
    front = end + distance
    top = curve[-1, 1] + slope[-1] * (front - curve[-1, 0])
    return np.vstack([[-distance, -WALL], [-distance, distance], curve, [front, top], [front, -WALL]])


def add_fossa(space: pymunk.Space, jaw: Any, radius: float, segment: float) -> None:
    """The fossa with its walls. Each segment knows its neighbours, so that a corner is touched once, not twice."""
    corners = _fossa_outline(jaw, radius, segment)
    extended = np.vstack([2 * corners[0] - corners[1], corners, 2 * corners[-1] - corners[-2]])
    points = [(float(x), float(z)) for x, z in extended]
    for before, start, end, after in zip(points, points[1:], points[2:], points[3:], strict=False):
        shape = pymunk.Segment(space.static_body, start, end, 0.0)
        shape.set_neighbors(before, after)
        shape.friction, shape.collision_type = 1.0, FOSSA  # pymunk multiplies the coefficients of both sides
        space.add(shape)


class BodyMotion(NamedTuple):
    """Place and motion of a pymunk body, in pymunk's units, to the bit."""

    position: tuple[float, float]
    angle: float
    velocity: tuple[float, float]
    angular_velocity: float


def motion_of(body: pymunk.Body) -> BodyMotion:
    """The present motion of ``body``."""
    (x, y), (x_rate, y_rate) = body.position, body.velocity
    return BodyMotion((x, y), body.angle, (x_rate, y_rate), body.angular_velocity)


def add_mandible(space: pymunk.Space, jaw: Any, radius: float, friction: float, motion: BodyMotion) -> pymunk.Body:
    """The mandible about its centre of mass, with the condyle's circle, in ``motion``."""
    body = pymunk.Body(float(jaw["mass"]), MM * MM * float(jaw["inertia"][1, 1]))
    body.angle, body.position = motion.angle, motion.position
    body.velocity, body.angular_velocity = motion.velocity, motion.angular_velocity
    centre = MM * jaw["centre_of_mass"][::2]
    condyle = pymunk.Circle(body, MM * radius, (-centre[0], -centre[1]))
    condyle.friction, condyle.collision_type = friction, CONDYLE
    space.add(body, condyle)
    return body
