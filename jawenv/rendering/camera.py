"""Parallel projection and shading of surfaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from jawenv.rendering.mesh import Mesh
from jawenv.rendering.palette import Colour

if TYPE_CHECKING:
    from jawenv.rendering.canvas import Box, Canvas

Array = NDArray[np.float64]

LIGHT = np.array([-0.35, 0.62, 0.70])  # from the viewer's upper left
AMBIENT = 0.20
HEIGHT_MM = 164.0  # that a view of the jaw shows
_SIDE_TURN = np.radians(9.0)


@dataclass(frozen=True)
class Camera:
    """Parallel projection of head-frame mm."""

    right: Array  # (3,) direction to the right of the picture
    toward: Array  # (3,) direction toward the viewer; up is z
    origin: tuple[float, float]  # place of the head's origin, design units
    scale: float  # design units per mm

    def project(self, points: Array) -> Array:
        """Project (..., 3) mm to (..., 2) design units."""
        across = points @ self.right * self.scale + self.origin[0]
        return np.stack([across, self.origin[1] - points[..., 2] * self.scale], axis=-1)

    def basis(self) -> Array:
        """Rows right, up, toward (3, 3)."""
        return np.stack([self.right, np.array([0.0, 0.0, 1.0]), self.toward])


def side_camera(box: Box, planar: bool) -> Camera:
    """Camera at the patient's right, turned a little to the front to show the far side, unless all is in one plane."""
    turn = 0.0 if planar else _SIDE_TURN
    c, s = np.cos(turn), np.sin(turn)
    x, y, width, height = box
    origin = (x + 0.29 * width, y + 0.285 * height)
    return Camera(np.array([c, s, 0.0]), np.array([s, -c, 0.0]), origin, height / HEIGHT_MM)


def front_camera(box: Box) -> Camera:
    """Face to face with the patient: the patient's left is on the right."""
    x, y, width, height = box
    origin = (x + width / 2, y + 0.285 * height)
    return Camera(np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0]), origin, height / HEIGHT_MM)


@dataclass(frozen=True)
class Pose:
    """Rigid motion: rotation (3, 3), then shift (3,) in mm."""

    rotation: Array
    shift: Array

    def apply(self, points: Array) -> Array:
        """Move body points (..., 3) into the head frame."""
        return points @ self.rotation.T + self.shift


FIXED = Pose(np.eye(3), np.zeros(3))


def draw_mesh(canvas: Canvas, camera: Camera, mesh: Mesh, pose: Pose, ramp: list[Colour], line: Colour) -> None:
    """Draw a surface, shaded from `ramp`, with a contour around its silhouette.

    The contour is drawn first: the faces then cover its inner half, so no line crosses the surface.
    """
    vertices = pose.apply(mesh.vertices)
    pixels = camera.project(vertices)
    normals = mesh.normals @ pose.rotation.T @ camera.basis().T
    facing = normals[:, 2] > 0
    contour = mesh.edges[facing[mesh.edge_faces[:, 0]] != facing[mesh.edge_faces[:, 1]]]
    canvas.segments(pixels[contour], line, 2.0)
    depth = (vertices @ camera.toward)[mesh.faces].mean(axis=1)
    order = np.flatnonzero(facing)[np.argsort(depth[facing], kind="stable")]
    shade = np.clip(AMBIENT + (1 - AMBIENT) * (normals[order] @ LIGHT), 0, 1)
    colours = [ramp[i] for i in (shade * (len(ramp) - 1)).astype(int).tolist()]
    canvas.polygons(pixels[mesh.faces[order]], colours)
