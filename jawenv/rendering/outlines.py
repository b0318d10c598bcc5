"""Shapes of the skull as tables in mm; x forward, y left, z up from midway between the condyles, jaw closed.

They are drawings after common anatomical proportions, placed on the model's own landmarks (condyle, incisor,
muscle attachments). Nothing is computed from them.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from jawenv.rendering.mesh import Mesh, crown, ellipsoid, merge, ribbon, slab, spline

Array = NDArray[np.float64]

CONDYLE_Y_MM = 49.0
PATH_X_MM: Array = np.linspace(-3.0, 25.0, 57)  # 3 mm behind to 25 mm in front of the fossa

# Left half of the mandible as a ladder: rear and lower border (x, y, z), front and upper border (x, y, z),
# thickness.
_RUNGS = np.array(
    [
        [-4.0, 48.5, -6.0, 4.5, 48.5, -4.5, 9.0],
        [-4.5, 48.0, -11.0, 6.0, 47.5, -10.5, 6.5],
        [-5.5, 47.0, -19.0, 11.0, 46.0, -15.5, 5.0],
        [-6.0, 46.5, -28.0, 17.0, 45.0, -13.5, 4.5],
        [-5.5, 46.0, -36.0, 22.5, 44.5, -6.0, 4.5],
        [-4.5, 45.5, -43.0, 27.0, 44.0, -1.0, 4.5],
        [-1.5, 45.5, -50.0, 31.5, 43.0, -9.0, 5.5],
        [4.5, 45.0, -55.5, 33.5, 41.0, -21.0, 7.0],
        [13.0, 44.5, -58.5, 36.5, 38.0, -31.0, 9.0],
        [24.0, 43.0, -61.0, 43.0, 33.5, -39.5, 11.0],
        [36.0, 39.0, -64.5, 52.0, 29.5, -43.0, 12.0],
        [48.0, 33.5, -68.5, 62.0, 26.0, -44.5, 12.0],
        [59.0, 27.0, -72.5, 71.0, 21.5, -45.0, 11.5],
        [69.0, 20.0, -76.0, 78.5, 15.5, -45.0, 11.5],
        [78.5, 12.5, -79.0, 84.0, 9.0, -45.0, 12.0],
        [84.0, 4.5, -80.5, 85.5, 3.0, -45.0, 13.0],
    ]
)
_RUNG_PIECES = 4
_SECTION_POINTS = 18

# Dental arch from the left second molar to the left central incisor: x, y, width along the arch, depth,
# height, waist.
_LOWER_CROWNS = np.array(
    [
        [49.0, 28.5, 10.4, 9.6, 7.0, 0.80],
        [59.0, 25.8, 10.8, 9.8, 7.4, 0.80],
        [67.6, 22.6, 7.2, 8.2, 8.0, 0.62],
        [74.0, 18.9, 7.0, 7.8, 8.4, 0.60],
        [79.6, 14.0, 6.8, 7.4, 9.6, 0.42],
        [84.4, 8.6, 5.8, 6.0, 8.8, 0.62],
        [86.8, 2.9, 5.4, 5.8, 8.6, 0.64],
    ]
)
_LOWER_NECK_Z = -45.5
_UPPER_CROWNS = np.array(
    [
        [47.5, 30.0, 9.8, 11.0, -7.0, 0.80],
        [57.6, 28.0, 10.2, 11.2, -7.2, 0.80],
        [66.4, 25.2, 6.9, 9.2, -8.0, 0.62],
        [73.2, 21.6, 7.0, 9.2, -8.4, 0.60],
        [80.2, 16.6, 7.4, 8.2, -10.2, 0.42],
        [86.4, 10.6, 6.8, 6.2, -10.0, 0.66],
        [89.8, 4.2, 8.4, 6.4, -11.2, 0.74],
    ]
)
_UPPER_NECK_Z = -28.6


@cache
def mandible() -> Mesh:
    """The whole mandible without teeth."""
    rungs = _rungs()
    heads = [_condyle(1.0), _condyle(-1.0)]
    return merge([ribbon(rungs[:, :3], rungs[:, 3:6], rungs[:, 6], _SECTION_POINTS), *heads])


@cache
def mandible_half(side: str) -> Mesh:
    """The left or the right half of the mandible with its condyle, open at the chin."""
    rungs = _rungs()
    middle = len(rungs) // 2
    half = rungs[: middle + 1] if side == "left" else rungs[middle:]
    body = ribbon(half[:, :3], half[:, 3:6], half[:, 6], _SECTION_POINTS)
    return merge([body, _condyle(1.0 if side == "left" else -1.0)])


def _rungs() -> Array:
    mirrored = _RUNGS[::-1].copy()
    mirrored[:, [1, 4]] *= -1
    return spline(np.vstack([_RUNGS, mirrored]), _RUNG_PIECES)


def _condyle(side: float) -> Mesh:
    # The head touches the path of the condyle from below.
    return ellipsoid(np.array([0.0, side * CONDYLE_Y_MM, -4.2]), np.array([5.0, 9.5, 4.2]))


@cache
def lower_teeth() -> Mesh:
    """Crowns of the fourteen lower teeth."""
    return _arch(_LOWER_CROWNS, _LOWER_NECK_Z)


@cache
def upper_teeth() -> Mesh:
    """Crowns of the fourteen upper teeth."""
    return _arch(_UPPER_CROWNS, _UPPER_NECK_Z)


def _arch(left: Array, neck_z: float) -> Mesh:
    right = left[::-1].copy()
    right[:, 1] *= -1
    teeth = np.vstack([left, right])
    along = np.gradient(teeth[:, :2], axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    return merge(
        [
            crown(
                np.array([row[0], row[1], neck_z]),
                np.array([*direction, 0.0]),
                (float(row[2]), float(row[3])),
                float(row[4]),
                float(row[5]),
            )
            for row, direction in zip(teeth, along, strict=True)
        ]
    )


@cache
def mouthpiece() -> Mesh:
    """Plate that the device holds, relative to the mouthpiece point."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 15)
    front = np.column_stack([2 + 10 * np.cos(angle), 25 * np.sin(angle)])
    back = np.array([[-13, 23], [-9, 15], [-4.5, 7], [-3.5, 0], [-4.5, -7], [-9, -15], [-13, -23]])
    return slab(np.vstack([front, back]), 3.2)


# Side view of the head in the mid-plane (x, z), and the parts that stand out from it.
SIDE_HEAD: Array = np.array([
    [-70, 70], [-84, 40], [-82, 8], [-66, -12], [-44, -18], [-30, -20], [-24, -34], [-17, -35], [-11, -22],
    [-9, -8], [-4, 4], [30, -4], [44, -14], [46, -30], [60, -31], [78, -30], [88, -29], [93, -25], [94, -17],
    [98, -11], [93, -4], [91, 8], [95, 20], [104, 13], [107, 15], [101, 30], [97, 40], [101, 52], [100, 70],
])  # fmt: skip
SIDE_ORBIT: Array = np.array([
    [70, 34], [66, 24], [68, 13], [75, 7], [84, 9], [89, 18], [90, 29], [86, 37], [78, 39],
])  # fmt: skip
SIDE_ARCH: Array = np.array([
    [12, 3], [20, 1.5], [34, 2.5], [48, 4], [58, 9], [64, 17], [68, 24], [71, 16], [74, 8], [80, 3], [76, -6],
    [68, -14], [60, -19], [55, -15], [50, -10], [40, -6.5], [28, -5], [20, -5], [13, -4],
])  # fmt: skip

# Front view of the head (y, z), left half from the top down to the middle of the upper jaw.
FRONT_HEAD: Array = np.array([
    [66, 70], [68, 46], [63, 30], [58, 20], [57, 10], [66, 3], [67, -5], [58, -9], [47, -14], [38, -22],
    [33, -28], [26, -31], [14, -31], [0, -31],
])  # fmt: skip
FRONT_ORBIT: Array = np.array([
    [12, 24], [14, 12], [22, 6], [34, 5], [42, 10], [45, 20], [43, 32], [35, 38], [22, 38], [14, 33],
])  # fmt: skip
FRONT_NOSE: Array = np.array([[0, 16], [4, 10], [8, 0], [12, -9], [9, -13], [4, -12], [0, -14]])


def face() -> Array:
    """Outline (N, 2) of the whole face without mandible in y and z."""
    return mirrored(spline(FRONT_HEAD, 6))


def closed(points: Array) -> Array:
    """Smooth closed curve through `points` (N, 2)."""
    return spline(np.vstack([points[-2:], points, points[:2]]), 6)[12:-12]


def mirrored(points: Array) -> Array:
    """Close a left half (y, z) with its mirror image."""
    return np.vstack([points, points[::-1] * [-1, 1]])
