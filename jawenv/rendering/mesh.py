"""Small closed surfaces, and how to build them: tubes of rungs, ellipsoids, tooth crowns, plates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class Mesh:
    """A surface of quadrilaterals, seen from outside; lengths in mm."""

    vertices: Array  # (V, 3)
    faces: Index  # (F, 4) vertex indices, counter-clockwise from outside; a triangle repeats its last index
    normals: Array  # (F, 3) outward unit normals
    edges: Index  # (E, 2) vertex indices of edges between two faces
    edge_faces: Index  # (E, 2) the two faces of each edge


def build(vertices: Array, faces: Index) -> Mesh:
    """Make a `Mesh`: drop faces without area, compute normals and shared edges."""
    corner = vertices[faces]
    normals = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    length = np.linalg.norm(normals, axis=1)
    keep = length > 1e-9
    faces, normals = faces[keep], normals[keep] / length[keep, None]
    owners: dict[tuple[int, int], list[int]] = {}
    for number, face in enumerate(faces.tolist()):
        for start, end in zip(face, face[1:] + face[:1], strict=True):
            if start != end:
                owners.setdefault((min(start, end), max(start, end)), []).append(number)
    shared = [(edge, pair) for edge, pair in owners.items() if len(pair) == 2]
    edges = np.array([edge for edge, _ in shared], dtype=np.int64).reshape(-1, 2)
    edge_faces = np.array([pair for _, pair in shared], dtype=np.int64).reshape(-1, 2)
    return Mesh(vertices, faces, normals, edges, edge_faces)


def merge(meshes: list[Mesh]) -> Mesh:
    """Put several surfaces into one."""
    offsets = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes])
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    faces = np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, offsets, strict=False)])
    return build(vertices, faces)


def spline(points: Array, per_segment: int) -> Array:
    """Catmull-Rom curve through `points` (N, K), with `per_segment` pieces between neighbours."""
    padded = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
    t = np.linspace(0, 1, per_segment, endpoint=False)[:, None]
    pieces = []
    for i in range(1, len(padded) - 2):
        p0, p1, p2, p3 = padded[i - 1 : i + 3]
        square, cube = 2 * p0 - 5 * p1 + 4 * p2 - p3, 3 * p1 - p0 - 3 * p2 + p3
        pieces.append(0.5 * (2 * p1 + (p2 - p0) * t + square * t**2 + cube * t**3))
    return np.vstack([*pieces, points[-1:]])


def loft(rings: Array) -> Mesh:
    """Join rings (N, K, 3) to a tube and close both ends; rings run so that the normals point outward."""
    count, per_ring = rings.shape[:2]
    ends = np.stack([rings[0].mean(axis=0), rings[-1].mean(axis=0)])
    vertices = np.vstack([rings.reshape(-1, 3), ends])
    i, k = np.meshgrid(np.arange(count - 1), np.arange(per_ring), indexing="ij")
    current, neighbour = i * per_ring + k, i * per_ring + (k + 1) % per_ring
    sides = np.stack([current, neighbour, neighbour + per_ring, current + per_ring], axis=-1).reshape(-1, 4)
    rim, following = np.arange(per_ring), (np.arange(per_ring) + 1) % per_ring
    base, first, last = (
        (count - 1) * per_ring,
        np.full(per_ring, count * per_ring),
        np.full(per_ring, count * per_ring + 1),
    )
    start = np.stack([following, rim, first, first], axis=1)
    end = np.stack([base + rim, base + following, last, last], axis=1)
    mesh = build(vertices, np.vstack([sides, start, end]))
    return mesh if _volume(mesh) > 0 else build(vertices, mesh.faces[:, ::-1])


def _volume(mesh: Mesh) -> float:
    centre = mesh.vertices[mesh.faces].mean(axis=1) - mesh.vertices.mean(axis=0)
    corner = mesh.vertices[mesh.faces]
    area = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    return float((centre * area).sum())


def ribbon(inner: Array, outer: Array, thickness: Array, around: int) -> Mesh:
    """Tube with flattened rounded sections: each reaches from `inner` to `outer` and is `thickness` wide.

    Args:
        inner: (N, 3) one edge of the ribbon.
        outer: (N, 3) the other edge.
        thickness: (N,) widths across.
        around: points of one section.
    """
    middle = (inner + outer) / 2
    half = (outer - inner) / 2
    across = np.cross(np.gradient(middle, axis=0), half)
    across *= (thickness / 2 / np.linalg.norm(across, axis=1))[:, None]
    angle = 2 * np.pi * np.arange(around) / around
    # Exponent below one makes a rounded plate of the ellipse.
    along, side = np.cos(angle), np.sign(np.sin(angle)) * np.abs(np.sin(angle)) ** 0.7
    return loft(middle[:, None] + along[:, None] * half[:, None] + side[:, None] * across[:, None])


def ellipsoid(centre: Array, radii: Array) -> Mesh:
    """Ellipsoid whose poles lie on the y axis."""
    polar = np.linspace(0.12, np.pi - 0.12, 9)[:, None]
    angle = 2 * np.pi * np.arange(16) / 16
    unit = np.stack(
        [
            np.sin(polar) * np.cos(angle),
            np.repeat(np.cos(polar), len(angle), axis=1),
            np.sin(polar) * np.sin(angle),
        ],
        axis=-1,
    )
    return loft(centre + radii * unit)


def crown(base: Array, along: Array, size: tuple[float, float], height: float, waist: float) -> Mesh:
    """Tooth crown that stands on `base` (3,).

    Args:
        base: centre of the neck of the tooth.
        along: (3,) unit vector along the dental arch.
        size: width along the arch, depth across it.
        height: signed height along z.
        waist: size at the biting end as a fraction of the widest section.
    """
    across = np.array([-along[1], along[0], 0.0])
    angle = 2 * np.pi * (np.arange(8) + 0.5) / 8
    # The exponent below one makes a rounded box of the ellipse.
    unit = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    unit = np.sign(unit) * np.abs(unit) ** 0.6
    ring = unit[:, :1] * along * size[0] / 2 + unit[:, 1:] * across * size[1] / 2
    levels = [(0.0, 0.82), (0.45, 1.0), (0.85, 0.5 + 0.5 * waist), (1.0, waist)]
    return loft(np.stack([base + ring * grow + [0, 0, height * level] for level, grow in levels]))


def slab(outline: Array, thickness: float) -> Mesh:
    """Flat plate: `outline` (K, 2) in x and y, extruded over `thickness` in z, centred on z = 0."""
    centre = outline.mean(axis=0)
    levels = [(-0.5, 0.97), (-0.3, 1.0), (0.3, 1.0), (0.5, 0.97)]
    rings = [np.insert(centre + (outline - centre) * grow, 2, level * thickness, axis=1) for level, grow in levels]
    return loft(np.stack(rings))
