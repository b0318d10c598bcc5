"""Conversion of a tracker's axes to those of the head: rigid bodies of markers, and three dental landmarks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from jawenv.base.errors import InputError, not_among, shown
from jawenv.base.files import read_mapping
from jawenv.trackers.tracks import Array, Tracks, listed, millimetres

LANDMARKS = ("incisor", "molar_left", "molar_right")
"""Between the lower incisors' edges, and the lower first molars: the contact points of ``Mandible.teeth_m``."""
CLOSED_S = 0.1
"""s at the beginning of a file, in which the jaw is closed."""
USUAL_MARKERS_MM, WORST_MARKERS_MM = 2.0, 5.0
"""Root mean square over all rows, and in the worst of them."""
WORST_LANDMARKS_MM = 10.0
FARTHEST_LANDMARK = 1e6
LEAST_TRAVEL_MM, LARGEST_TRAVEL_MM = 2.0, 100.0
FIXED = "fixed"
SMOOTHED = "_smooth"
"""End of the name of a body whose motion the tracker's software has smoothed."""


@dataclass(frozen=True, eq=False)
class Motion:
    """A rigid body's motion since the reference with the jaw closed: x -> turned (x - reference) + place."""

    turned: Array
    """(T, 3, 3) rotation since the reference; NaN where the tracker lost the body."""
    place: Array
    """(T, 3) mm of the body's origin; NaN likewise."""
    reference: Array
    """(3,) mm of it in the reference."""
    residual_mm: float = 0.0
    """Root mean square distance of markers from a rigid body; 0 for a body of the tracker's own."""
    worst_mm: float = 0.0
    """The same of the worst row."""

    def carried(self, point: Array) -> Array:
        """(T, 3) places of a point (3,) of the body, given where it is in the reference."""
        return (self.turned @ (point - self.reference)[:, None])[..., 0] + self.place


@dataclass(frozen=True, eq=False)
class _Registration:
    """The rigid motion x -> turn (x - file) + head from the file's axes to head axes."""

    turn: Array  # (3, 3) rotation
    file: Array  # (3,) mm, the landmarks' centre in the file
    head: Array  # (3,) mm, that of the model's
    residual_mm: float  # root mean square distance of the landmarks from the model's


def body_motion(tracks: Tracks, names: Sequence[str]) -> Motion:
    """The motion of one body of the file, or of three or more markers."""
    for name in names:
        if name not in tracks.places:
            near = not_among(f"{tracks.path}: --jaw or --head", name, [])
            raise InputError(f"{near}{listed(tracks.places)}")
    if len(set(names)) < len(names):
        raise InputError(f"{tracks.path}: --jaw or --head is {listed(names)}; allowed: each name once")
    closed = tracks.time - tracks.time[0] <= CLOSED_S
    if len(names) == 1 and names[0] in tracks.rotations:
        place, rotations = tracks.places[names[0]], tracks.rotations[names[0]]
        seen = np.isfinite(place).all(axis=1) & np.isfinite(rotations).all(axis=(1, 2))
        _check_seen(seen & closed, tracks, names)
        mean = Rotation.from_matrix(rotations[seen & closed]).mean().as_matrix()
        return Motion(rotations @ mean.T, place, place[seen & closed].mean(axis=0))
    if len(names) < 3:
        raise InputError(f"{tracks.path}: {', '.join(names)}: {len(names)} markers; allowed: three or more of one body")
    return _of_markers(tracks, names, closed)


def _of_markers(tracks: Tracks, names: Sequence[str], closed: NDArray[np.bool_]) -> Motion:
    points = np.stack([tracks.places[name] for name in names], axis=1)
    seen = np.isfinite(points).all(axis=(1, 2))
    _check_seen(seen & closed, tracks, names)
    shape = points[seen & closed].mean(axis=0)
    centre = shape.mean(axis=0)
    place, turned = np.full((len(points), 3), np.nan), np.full((len(points), 3, 3), np.nan)
    place[seen] = points[seen].mean(axis=1)
    distances = []
    for i in np.flatnonzero(seen):
        rotation, distance = Rotation.align_vectors(points[i] - place[i], shape - centre)
        turned[i] = rotation.as_matrix()
        distances.append(distance)
    each = np.array(distances) / np.sqrt(len(names))
    residual, worst = float(np.sqrt(np.mean(each**2))), int(np.argmax(each))
    for value, most, when in (
        (residual, USUAL_MARKERS_MM, "usually"),
        (float(each[worst]), WORST_MARKERS_MM, f"at {tracks.time[seen][worst]:.4g} s"),
    ):
        if value > most:
            raise InputError(
                f"{tracks.path}: markers {listed(names)} move {value:.3g} mm against each other {when}; "
                f"allowed: {most:g} mm, markers of one body (empty where one is lost)"
            )
    return Motion(turned, place, centre, residual, float(each[worst]))


def _check_seen(seen: NDArray[np.bool_], tracks: Tracks, names: Sequence[str]) -> None:
    if not seen.any():
        raise InputError(
            f"{tracks.path}: {listed(names)} is lost in the first {CLOSED_S:g} s; allowed: seen, with the jaw closed"
        )


def relative(jaw: Motion, head: Motion | None) -> Motion:
    """The jaw's motion seen from the head, in the file's axes as the head stood in the reference."""
    if head is None:
        return jaw
    back = head.turned.transpose(0, 2, 1)
    place = (back @ (jaw.place - head.place)[..., None])[..., 0] + head.reference
    residuals = max(jaw.residual_mm, head.residual_mm), max(jaw.worst_mm, head.worst_mm)
    return Motion(back @ jaw.turned, place, jaw.reference, *residuals)


def read_landmarks(path: Path, tracks: Tracks, axes: Array) -> Array:
    """(3, 3) mm: places of ``LANDMARKS`` with the jaw closed; numbers in mm, or the ``unit`` in the file.

    Args:
        path: of the file.
        tracks: with the markers that a landmark may be, already turned.
        axes: (3, 3) by which numbers, which are in the tracker's axes, are turned as well.
    """
    fields = read_mapping(path)
    for name in fields:
        if name not in (*LANDMARKS, "unit"):
            raise not_among(f"{path}: landmark", name, (*LANDMARKS, "unit"))
    unit = fields.get("unit", "mm")
    if not isinstance(unit, str):
        raise InputError(f"{path}: unit is {shown(unit)}; allowed: a text, as mm")
    scale = millimetres(unit, str(path)) * axes
    places = []
    for name in LANDMARKS:
        if name not in fields:
            raise InputError(f"{path}: {name} is missing; allowed: {', '.join(LANDMARKS)}")
        places.append(_landmark(fields[name], scale, tracks, f"{path}: {name}"))
    return np.array(places)


def _landmark(value: Any, scale: Array, tracks: Tracks, where: str) -> Array:
    if isinstance(value, str) and value in tracks.places:
        closed = tracks.places[value][tracks.time - tracks.time[0] <= CLOSED_S]
        if np.isfinite(closed).all(axis=1).any():
            mean: Array = np.nanmean(closed, axis=0)
            return mean
    elif isinstance(value, list) and len(value) == 3 and all(_is_coordinate(number) for number in value):
        place: Array = scale @ np.array(value, dtype=np.float64)
        return place
    raise InputError(f"{where} is {shown(value)}; allowed: three numbers, or a marker seen at the beginning")


def _is_coordinate(number: Any) -> bool:
    return type(number) in (int, float) and abs(number) < FARTHEST_LANDMARK


def register(landmarks: Array, teeth: Array, path: str) -> _Registration:
    """The rigid motion that brings landmarks (3, 3) nearest to the model's teeth (3, 3), mm both, least squares."""
    file, head = landmarks.mean(axis=0), teeth.mean(axis=0)
    size = np.linalg.norm(landmarks - file) / np.linalg.norm(teeth - head)
    if not 0.5 <= size <= 2.0:
        raise InputError(f"{path}: landmarks lie {size:.3g} times as far apart as ours; allowed: 0.5 to 2 (the unit?)")
    rotation, distance = Rotation.align_vectors(teeth - head, landmarks - file)
    residual = float(distance) / np.sqrt(3.0)
    if residual > WORST_LANDMARKS_MM:
        allowed = f"{WORST_LANDMARKS_MM:g} mm: incisor and first molars of one jaw"
        raise InputError(f"{path}: landmarks lie {residual:.3g} mm from ours; allowed: {allowed}")
    return _Registration(rotation.as_matrix(), file, head, residual)


def in_head_axes(motion: Motion, registration: _Registration, mouthpiece: Array) -> tuple[Array, Array]:
    """Place (T, 3) in mm and rotation (T, 3, 3) of the mouthpiece in head axes; it begins at ``mouthpiece`` (3,)."""
    turn = registration.turn
    point = turn.T @ (mouthpiece - registration.head) + registration.file
    place = (motion.carried(point) - registration.file) @ turn.T + registration.head
    check_travel(place)
    return place, turn @ motion.turned @ turn.T


def check_travel(place: Array) -> None:
    """Check how far a mouthpiece moves from where it was first, (T, 3) mm."""
    seen = place[np.isfinite(place).all(axis=1)]
    travel = float(np.linalg.norm(seen - seen[:1], axis=1).max(initial=0.0))
    if not LEAST_TRAVEL_MM <= travel <= LARGEST_TRAVEL_MM:
        allowed = f"{LEAST_TRAVEL_MM:g} to {LARGEST_TRAVEL_MM:g} mm (the unit, --jaw and --head?)"
        raise InputError(f"the mouthpiece moves {travel:.3g} mm; allowed: {allowed}")


def names_of(text: str | None, tracks: Tracks, option: str) -> list[str]:
    """The names in an option, or the file's only body beside smoothed ones."""
    if text is not None:
        return [name.strip() for name in text.split(",")]
    bodies = [name for name in tracks.rotations if not name.endswith(SMOOTHED)]
    if len(bodies) == 1 and set(tracks.rotations) == set(tracks.places):
        return bodies
    if not tracks.places:
        raise InputError(f"{tracks.path}: holds no marker and no body; allowed: one or more, beside forces")
    names = listed(tracks.rotations or tracks.places)
    why = f" (what ends in {SMOOTHED} has no noise of its own)" if tracks.rotations and not bodies else ""
    raise InputError(f"{tracks.path}: {option} is missing; allowed: names among {names}{why}")
