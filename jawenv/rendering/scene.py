"""The content of a picture: one moment of an episode as plain numbers, checked on the way in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.ladder import Plant

Array = NDArray[np.float64]
Moment = tuple[float, float, float, float]
"""Time (s), opening, side and fore-aft excursion (mm)."""

_PLANAR_M = 1e-3
_SCALARS = (
    "fossa_drop_m",
    "fossa_frequency",
    "condyle_half_width_m",
    "governor",
    "time_s",
    "episode_s",
    "opening_mm",
    "information_nats",
)


@dataclass(frozen=True)
class Scene:
    """One moment of an episode, in SI units and the head frame (x forward, y left, z up).

    M is the number of lines of action, P the number of parameters. Every muscle needs its two parameters
    `log_F_o/<muscle>` and `log_b/<muscle>` among `parameter_names`; further parameters are not drawn.
    """

    muscle_names: tuple[str, ...]
    """(M,) the muscle that each line belongs to; lines that share a muscle repeat its name."""
    muscle_origin_m: Array  # (M, 3) origins on the skull
    muscle_insertion_m: Array  # (M, 3) insertions on the mandible as it stands now
    muscle_tension_N: Array  # (M,) tensions, not negative
    contact_m: Array  # (3,) point midway between the condyles now, where it really is
    rotation: Array  # (3, 3) body axes as columns, C^T
    plant: Plant
    """What holds the condyles: `midline` binds the point between them to the path, `contact` lets it press on
    its fossa or lift off it.
    """
    slides: bool  # whether the condyles can leave the place where they rest
    condyle_half_width_m: float  # half the distance between the condyles' centres
    fossa_drop_m: float  # d of the condyle's path z = d (cos f x - 1)
    fossa_frequency: float  # f of the same path, rad/m
    mouthpiece_m: Array  # (3,) point where the device holds the mandible now
    mouthpiece_force_N: Array  # (3,) force of the device on the mandible
    parameter_names: tuple[str, ...]  # (P,) names of the parameters
    belief_mean: Array  # (P,) posterior means of the natural logs
    belief_cov: Array  # (P, P) posterior covariance, its diagonal positive
    prior_mean: Array  # (P,) prior means of the natural logs
    prior_sd: Array  # (P,) prior standard deviations, positive
    truth: Array | None  # (P,) true natural logs, or None where they are unknown or to be hidden
    comfort: Mapping[str, float]  # used fraction of the soft limit by name of the limit
    comfort_hard: Mapping[str, float]  # fraction that is the hard limit, above 1, by the same names
    governor: float  # share of the last step in which the governor acted, 0 to 1
    time_s: float  # time since the start of the episode
    episode_s: float  # length of the episode, positive
    opening_mm: float  # opening at the incisors
    opening_limits_mm: Array  # (2,) the soft and the hard limit of the opening
    excursion_mm: Array  # (2,) how far the mouthpiece is to the left of its rest and in front of its natural path
    excursion_soft_mm: Array  # (2,) their soft limits to either side
    information_nats: float  # information gained so far
    title: str  # one line above the picture

    def __post_init__(self) -> None:
        """Check every field."""
        self._check_names()
        for field, shape in self._shapes().items():
            object.__setattr__(self, field, _array(field, getattr(self, field), shape))
        for field in _SCALARS:
            if not np.isfinite(getattr(self, field)):
                raise InputError(f"{field}: {getattr(self, field)} is not a finite number")
        _require_all("muscle_tension_N", self.muscle_tension_N, self.muscle_tension_N >= 0, "at least 0")
        _require_all("prior_sd", self.prior_sd, self.prior_sd > 0, "above 0")
        variance = np.diagonal(self.belief_cov)
        _require_all("belief_cov", variance, variance > 0, "above 0 on the diagonal")
        if self.plant not in get_args(Plant):
            raise InputError(f"plant is '{self.plant}'; allowed: {', '.join(get_args(Plant))}")
        if np.abs(self.rotation @ self.rotation.T - np.eye(3)).max() > 1e-3:
            raise InputError("rotation: columns are not orthonormal; a rotation matrix is needed")
        if self.episode_s <= 0:
            raise InputError(f"episode_s is {self.episode_s}; allowed: numbers above 0")
        if not 0 <= self.governor <= 1:
            raise InputError(f"governor is {self.governor}; allowed: 0 to 1")
        self._check_comfort()

    @property
    def belief_sd(self) -> Array:
        """(P,) posterior standard deviations."""
        deviations: Array = np.sqrt(np.diagonal(self.belief_cov))
        return deviations

    @property
    def moment(self) -> Moment:
        """This scene's entry in a trace."""
        return (self.time_s, self.opening_mm, float(self.excursion_mm[0]), float(self.excursion_mm[1]))

    @property
    def muscles(self) -> tuple[str, ...]:
        """The muscles, each once."""
        return tuple(dict.fromkeys(self.muscle_names))

    @property
    def planar(self) -> bool:
        """Whether all muscles lie in the plane between left and right."""
        return float(np.abs([self.muscle_origin_m[:, 1], self.muscle_insertion_m[:, 1]]).max()) < _PLANAR_M

    @property
    def condyles_m(self) -> Array:
        """(2, 3) centres of the left and of the right condyle."""
        aside = self.condyle_half_width_m * self.rotation[:, 1]
        return np.stack([self.contact_m + aside, self.contact_m - aside])

    @property
    def condyle_gap_m(self) -> Array:
        """(2,) how far the left and the right condyle stand off their fossa; negative while they press on it."""
        return self.path_m(self.condyles_m[:, 0]) - self.condyles_m[:, 2]

    def path_m(self, x: Array) -> Array:
        """Height of the condyle's path at x."""
        height: Array = self.fossa_drop_m * (np.cos(self.fossa_frequency * x) - 1)
        return height

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
            "belief_cov": (parameters, parameters),
            "opening_limits_mm": (2,),
            "excursion_mm": (2,),
            "excursion_soft_mm": (2,),
        }
        for field in ("belief_mean", "prior_mean", "prior_sd", "truth"):
            if getattr(self, field) is not None or field != "truth":
                shapes[field] = (parameters,)
        return shapes

    def _check_names(self) -> None:
        if not self.muscle_names:
            raise InputError("muscle_names: empty; at least one line is needed")
        for muscle in self.muscle_names:
            for parameter in (f"log_F_o/{muscle}", f"log_b/{muscle}"):
                if parameter not in self.parameter_names:
                    raise InputError(f"parameter_names: '{parameter}' is missing")

    def _check_comfort(self) -> None:
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
        raise InputError(f"{field} has shape {array.shape}; allowed: {shape}")
    if not np.isfinite(array).all():
        raise InputError(f"{field} holds {array[~np.isfinite(array)][0]}; allowed: finite numbers")
    return array


def _require_all(field: str, array: Array, allowed: NDArray[np.bool_], rule: str) -> None:
    if not allowed.all():
        raise InputError(f"{field} holds {array[~allowed][0]}; allowed: {rule}")
