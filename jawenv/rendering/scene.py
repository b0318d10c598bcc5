"""The content of a picture: one moment of an episode as plain numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from jawenv.ladder import Plant

Array = NDArray[np.float64]
Moment = tuple[float, float, float, float]
"""Time (s), opening, side and fore-aft excursion (mm)."""

_PLANAR_M = 1e-3


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
    time_s: float  # time since the start of the episode
    episode_s: float  # length of the episode, positive
    opening_mm: float  # opening at the incisors
    opening_limits_mm: Array  # (2,) the soft and the hard limit of the opening
    excursion_mm: Array  # (2,) how far the mouthpiece is to the left of its rest and in front of its natural path
    excursion_soft_mm: Array  # (2,) their soft limits to either side
    information_nats: float  # information gained so far
    title: str  # one line above the picture
    truth: Array | None = None  # (P,) true natural logs, or None where they are unknown or to be hidden
    comfort: Mapping[str, float] = field(default_factory=dict)  # used fraction of the soft limit by name of the limit
    comfort_hard: Mapping[str, float] = field(default_factory=dict)
    """Fraction that is the hard limit, above 1, by the same names."""
    governor: float = 0.0  # share of the last step in which the governor acted, 0 to 1

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
