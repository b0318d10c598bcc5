"""From a tracker's axes to those of the head: rigid bodies of markers, and three dental landmarks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from jawenv.errors import InputError, not_among, shown
from jawenv.files import read_mapping
from jawenv.laboratory.trackers.tracks import Array, Tracks, millimetres

LANDMARKS = ("incisor", "molar_left", "molar_right")
"""Between the lower incisors' edges, and the lower first molars: the contact points of ``Mandible.teeth_m``."""
CLOSED_S = 0.1
"""s at the beginning of a file, in which the jaw is closed."""
WORST_MARKERS_MM, WORST_LANDMARKS_MM = 5.0, 10.0
LEAST_TRAVEL_MM, LARGEST_TRAVEL_MM = 2.0, 100.0
FIXED = "fixed"


@dataclass(frozen=True, eq=False)
class Motion:
    """The motion of a rigid body since the reference, in which the jaw is closed: x -> turned (x - reference) + place.

    Attributes:
        turned: (T, 3, 3) rotation since the reference; NaN where the tracker lost the body.
        place: (T, 3) mm of the body's origin; NaN likewise.
        reference: (3,) mm of it in the reference.
        residual_mm: root mean square distance of markers from a rigid body; 0 for a body of the tracker's own.
    """

    turned: Array
    place: Array
    reference: Array
    residual_mm: float = 0.0

    def carried(self, point: Array) -> Array:
        """(T, 3) places of a point (3,) of the body, given where it is in the reference."""
        return (self.turned @ (point - self.reference)[:, None])[..., 0] + self.place


@dataclass(frozen=True, eq=False)
class Registration:
    """The rigid motion x -> turn (x - file) + head from the file's axes to head axes.

    Attributes:
        turn: (3, 3) rotation.
        file: (3,) mm, the landmarks' centre in the file.
        head: (3,) mm, that of the model's.
        residual_mm: root mean square distance of the landmarks from the model's.
    """

    turn: Array
    file: Array
    head: Array
    residual_mm: float


def body_motion(tracks: Tracks, names: Sequence[str]) -> Motion:
    """The motion of one body of the file, or of three or more markers.

    Raises:
        InputError: an unknown name, too few markers, markers that are not on one body, or none seen at the beginning.
    """
    for name in names:
        if name not in tracks.places:
            raise not_among(f"{tracks.path}: --jaw or --head", name, tracks.places)
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
    residual = float(np.sqrt(np.mean(np.square(distances)) / len(names)))
    if residual > WORST_MARKERS_MM:
        raise InputError(
            f"{tracks.path}: markers {', '.join(names)} move {residual:.3g} mm against each other; "
            f"allowed: {WORST_MARKERS_MM:g} mm, markers of one body"
        )
    return Motion(turned, place, centre, residual)


def _check_seen(seen: NDArray[np.bool_], tracks: Tracks, names: Sequence[str]) -> None:
    if not seen.any():
        raise InputError(
            f"{tracks.path}: {', '.join(names)} is lost in the first {CLOSED_S:g} s; allowed: seen, with the jaw closed"
        )


def relative(jaw: Motion, head: Motion | None) -> Motion:
    """The jaw's motion seen from the head, in the file's axes as the head stood in the reference."""
    if head is None:
        return jaw
    back = head.turned.transpose(0, 2, 1)
    place = (back @ (jaw.place - head.place)[..., None])[..., 0] + head.reference
    return Motion(back @ jaw.turned, place, jaw.reference, max(jaw.residual_mm, head.residual_mm))


def read_landmarks(path: Path, tracks: Tracks) -> Array:
    """(3, 3) mm: places of ``LANDMARKS`` with the jaw closed, in the tracker's axes; mm, or the ``unit`` in the file.

    Raises:
        InputError: a missing or unknown landmark, or one that is neither three numbers nor a marker of the file.
    """
    fields = read_mapping(path)
    for name in fields:
        if name not in (*LANDMARKS, "unit"):
            raise not_among(f"{path}: landmark", name, (*LANDMARKS, "unit"))
    scale = millimetres(fields.get("unit", "mm"), str(path))
    places = []
    for name in LANDMARKS:
        if name not in fields:
            raise InputError(f"{path}: {name} is missing; allowed: {', '.join(LANDMARKS)}")
        places.append(_landmark(fields[name], scale, tracks, f"{path}: {name}"))
    return np.array(places)


def _landmark(value: Any, scale: float, tracks: Tracks, where: str) -> Array:
    if isinstance(value, str) and value in tracks.places:
        closed = tracks.places[value][tracks.time - tracks.time[0] <= CLOSED_S]
        if np.isfinite(closed).all(axis=1).any():
            mean: Array = np.nanmean(closed, axis=0)
            return mean
    elif isinstance(value, list) and len(value) == 3 and all(type(number) in (int, float) for number in value):
        return scale * np.array(value, dtype=np.float64)
    raise InputError(f"{where} is {shown(value)}; allowed: three numbers, or a marker seen at the beginning")


def register(landmarks: Array, teeth: Array, path: str) -> Registration:
    """The rigid motion that brings landmarks (3, 3) nearest to the model's teeth (3, 3), mm both, least squares.

    Raises:
        InputError: triangles of other sizes, or a residual above ``WORST_LANDMARKS_MM``.
    """
    file, head = landmarks.mean(axis=0), teeth.mean(axis=0)
    size = np.linalg.norm(landmarks - file) / np.linalg.norm(teeth - head)
    if not 0.5 <= size <= 2.0:
        raise InputError(f"{path}: landmarks lie {size:.3g} times as far apart as ours; allowed: 0.5 to 2 (the unit?)")
    rotation, distance = Rotation.align_vectors(teeth - head, landmarks - file)
    residual = float(distance) / np.sqrt(3.0)
    if residual > WORST_LANDMARKS_MM:
        allowed = f"{WORST_LANDMARKS_MM:g} mm: incisor and first molars of one jaw"
        raise InputError(f"{path}: landmarks lie {residual:.3g} mm from ours; allowed: {allowed}")
    return Registration(rotation.as_matrix(), file, head, residual)


def in_head_axes(motion: Motion, registration: Registration, mouthpiece: Array) -> tuple[Array, Array]:
    """Place (T, 3) in mm and rotation (T, 3, 3) of the mouthpiece, head axes; ``mouthpiece`` (3,) is its first place.

    Raises:
        InputError: it hardly moves, or moves farther than a jaw.
    """
    turn = registration.turn
    point = turn.T @ (mouthpiece - registration.head) + registration.file
    place = (motion.carried(point) - registration.file) @ turn.T + registration.head
    check_travel(place)
    return place, turn @ motion.turned @ turn.T


def check_travel(place: Array) -> None:
    """Check how far a mouthpiece moves from where it was first, (T, 3) mm.

    Raises:
        InputError: less than ``LEAST_TRAVEL_MM`` or more than ``LARGEST_TRAVEL_MM``.
    """
    travel = float(np.nanmax(np.linalg.norm(place - place[np.isfinite(place).all(axis=1)][:1], axis=1)))
    if not LEAST_TRAVEL_MM <= travel <= LARGEST_TRAVEL_MM:
        allowed = f"{LEAST_TRAVEL_MM:g} to {LARGEST_TRAVEL_MM:g} mm (the unit, --jaw and --head?)"
        raise InputError(f"the mouthpiece moves {travel:.3g} mm; allowed: {allowed}")


def names_of(text: str | None, tracks: Tracks, option: str) -> list[str]:
    """The names in an option, or the file's only body.

    Raises:
        InputError: nothing was named, and there is more than one to choose from.
    """
    if text is not None:
        return [name.strip() for name in text.split(",")]
    if len(tracks.rotations) == 1 and set(tracks.rotations) == set(tracks.places):
        return list(tracks.rotations)
    allowed: Mapping[str, Array] = tracks.rotations or tracks.places
    raise InputError(f"{tracks.path}: {option} is missing; allowed: names among {', '.join(allowed)}")
