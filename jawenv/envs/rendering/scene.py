"""What a picture is made of: one moment of an episode as plain numbers, checked on the way in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jawenv.errors import InputError

Array = NDArray[np.float64]

_SCALARS = (
    "fossa_drop_m",
    "fossa_frequency",
    "governor",
    "time_s",
    "episode_s",
    "opening_mm",
    "information_nats",
)


@dataclass(frozen=True)
class Scene:
    """One moment of an episode, in SI units and the head frame (x forward, y left, z up).

    M is the number of muscles, P the number of parameters. Every muscle needs its two parameters
    `log_F_o/<muscle>` and `log_b/<muscle>` among `parameter_names`; further parameters are not drawn.

    Attributes:
        muscle_names: (M,) names that end in `_left` or `_right`.
        muscle_origin_m: (M, 3) origins on the skull.
        muscle_insertion_m: (M, 3) insertions on the mandible as it stands now.
        muscle_tension_N: (M,) tensions, not negative.
        contact_m: (3,) mid-condyle contact point now.
        rotation: (3, 3) body axes as columns, C^T.
        fossa_drop_m: d of the condyle's path z = d (cos f x - 1).
        fossa_frequency: f of the same path, rad/m.
        mouthpiece_m: (3,) point where the device holds the mandible now.
        mouthpiece_force_N: (3,) force of the device on the mandible.
        parameter_names: (P,) names of the parameters.
        belief_mean: (P,) posterior means of the natural logs.
        belief_sd: (P,) posterior standard deviations, positive.
        prior_mean: (P,) prior means of the natural logs.
        prior_sd: (P,) prior standard deviations, positive.
        truth: (P,) true natural logs, or None where they are unknown or to be hidden.
        comfort: used fraction of the soft limit by name of the limit.
        comfort_hard: fraction that is the hard limit, above 1, by the same names.
        governor: share of the last step in which the governor acted, 0 to 1.
        time_s: time since the start of the episode.
        episode_s: length of the episode, positive.
        opening_mm: opening at the incisors.
        information_nats: information gained so far.
        title: one line above the picture.

    Raises:
        InputError: a value is not finite, out of range or of the wrong shape; the message names the field.
    """

    muscle_names: tuple[str, ...]
    muscle_origin_m: Array
    muscle_insertion_m: Array
    muscle_tension_N: Array
    contact_m: Array
    rotation: Array
    fossa_drop_m: float
    fossa_frequency: float
    mouthpiece_m: Array
    mouthpiece_force_N: Array
    parameter_names: tuple[str, ...]
    belief_mean: Array
    belief_sd: Array
    prior_mean: Array
    prior_sd: Array
    truth: Array | None
    comfort: Mapping[str, float]
    comfort_hard: Mapping[str, float]
    governor: float
    time_s: float
    episode_s: float
    opening_mm: float
    information_nats: float
    title: str

    def __post_init__(self) -> None:
        """Check every field."""
        for field, shape in self._shapes().items():
            object.__setattr__(self, field, _array(field, getattr(self, field), shape))
        for field in _SCALARS:
            if not np.isfinite(getattr(self, field)):
                raise InputError(f"{field}: {getattr(self, field)} is not a finite number")
        _require_all("muscle_tension_N", self.muscle_tension_N, self.muscle_tension_N >= 0, "at least 0")
        for field in ("belief_sd", "prior_sd"):
            _require_all(field, getattr(self, field), getattr(self, field) > 0, "above 0")
        if np.abs(self.rotation @ self.rotation.T - np.eye(3)).max() > 1e-3:
            raise InputError("rotation: columns are not orthonormal; a rotation matrix is needed")
        if self.episode_s <= 0:
            raise InputError(f"episode_s: {self.episode_s} must be above 0")
        if not 0 <= self.governor <= 1:
            raise InputError(f"governor: {self.governor} must lie between 0 and 1")
        self._check_names()

    def _shapes(self) -> dict[str, tuple[int, ...]]:
        muscles, parameters = len(self.muscle_names), len(self.parameter_names)
        shapes: dict[str, tuple[int, ...]] = {
            "muscle_origin_m": (muscles, 3),
            "muscle_insertion_m": (muscles, 3),
            "muscle_tension_N": (muscles,),
            "contact_m": (3,),
            "rotation": (3, 3),
            "mouthpiece_m": (3,),
            "mouthpiece_force_N": (3,),
        }
        for field in ("belief_mean", "belief_sd", "prior_mean", "prior_sd", "truth"):
            if getattr(self, field) is not None or field != "truth":
                shapes[field] = (parameters,)
        return shapes

    def _check_names(self) -> None:
        for muscle in self.muscle_names:
            if not muscle.endswith(("_left", "_right")):
                raise InputError(f"muscle_names: '{muscle}' must end in _left or _right")
            for parameter in (f"log_F_o/{muscle}", f"log_b/{muscle}"):
                if parameter not in self.parameter_names:
                    raise InputError(f"parameter_names: '{parameter}' is missing")
        for name, used in self.comfort.items():
            if not np.isfinite(used):
                raise InputError(f"comfort: '{name}' is {used}, not a finite number")
            hard = self.comfort_hard.get(name)
            if hard is None or not np.isfinite(hard) or hard <= 1:
                raise InputError(f"comfort_hard: '{name}' is {hard}; a fraction above 1 is needed")


def _array(field: str, value: object, shape: tuple[int, ...]) -> Array:
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{field}: not an array of numbers of shape {shape}") from None
    if array.shape != shape:
        raise InputError(f"{field}: shape {array.shape} must be {shape}")
    if not np.isfinite(array).all():
        raise InputError(f"{field}: {array[~np.isfinite(array)][0]} found; all values must be finite")
    return array


def _require_all(field: str, array: Array, allowed: NDArray[np.bool_], rule: str) -> None:
    if not allowed.all():
        raise InputError(f"{field}: {array[~allowed][0]} found; all values must be {rule}")
