"""Shapes of condyle, fossa and teeth in pymunk's space, in mm."""

from __future__ import annotations

from typing import Any

import numpy as np
import pymunk
from numpy.typing import NDArray

MM = 1e3
# mm of overlap that contact rests on. Without it a contact is lost in every other step and the body falls back onto
# the fossa with the speed of one step's free fall.
SLOP = 0.01
CONDYLE, FOSSA, TOOTH, UPPER_TEETH = 1, 2, 3, 4
WALL = 15.0  # mm that the walls at both ends reach down
END = 1.5  # crests from the roof to the front wall
CUSP = 1.0  # mm, radius of a tooth's contact
BEYOND = 15.0  # mm that the upper teeth's plane goes on before the first and behind the last tooth


def fossa_outline(jaw: Any, radius: float, segment: float) -> NDArray[np.float64]:
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
    corners = fossa_outline(jaw, radius, segment)
    around = np.vstack([2 * corners[0] - corners[1], corners, 2 * corners[-1] - corners[-2]])
    points = [(float(x), float(z)) for x, z in around]
    for before, start, end, after in zip(points, points[1:], points[2:], points[3:], strict=False):
        shape = pymunk.Segment(space.static_body, start, end, 0.0)
        shape.set_neighbors(before, after)
        shape.friction, shape.collision_type = 1.0, FOSSA  # pymunk multiplies the coefficients of both sides
        space.add(shape)


def add_upper_teeth(space: pymunk.Space, jaw: Any, friction: float) -> None:
    """The upper teeth: a thick plane through the places of the lower ones when the jaw is closed."""
    teeth = MM * jaw["teeth"][np.argsort(jaw["teeth"][:, 0])][:, ::2]
    along = (teeth[-1] - teeth[0]) / np.linalg.norm(teeth[-1] - teeth[0])
    up = np.array([-along[1], along[0]]) * CUSP
    start, end = teeth[0] - BEYOND * along + up, teeth[-1] + BEYOND * along + up
    shape = pymunk.Segment(space.static_body, (start[0], start[1]), (end[0], end[1]), CUSP)
    shape.friction, shape.collision_type = friction, UPPER_TEETH
    space.add(shape)


def add_mandible(space: pymunk.Space, jaw: Any, radius: float, friction: float, teeth: bool) -> pymunk.Body:
    """The mandible about its centre of mass: the condyle's circle and, with ``teeth``, those of the cusps."""
    body = pymunk.Body(float(jaw["mass"]), MM * MM * float(jaw["inertia"][1, 1]))
    centre = MM * jaw["centre_of_mass"][::2]
    condyle = pymunk.Circle(body, MM * radius, (-centre[0], -centre[1]))
    condyle.friction, condyle.collision_type = friction, CONDYLE
    space.add(body, condyle)
    places = np.unique(MM * jaw["teeth"][:, ::2], axis=0) if teeth else np.empty((0, 2))
    for x, z in places:
        cusp = pymunk.Circle(body, CUSP, (float(x - centre[0]), float(z - CUSP - centre[1])))
        cusp.friction, cusp.collision_type = 1.0, TOOTH
        space.add(cusp)
    return body
