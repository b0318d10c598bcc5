"""Sets of muscles with their lines of action, from one closing muscle in all to twelve portions.

A *muscle* has a stiffness of its own, F_o and b. A *line* is a straight line of action; a muscle may have several,
which then share its F_o and b.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy.arrays import FrozenArrays
from jawenv.anatomy.attachments import Attachment, attachment
from jawenv.base.errors import InputError

__all__ = [
    "MUSCLE_NAMES",
    "PARAMETER_NAMES",
    "PORTIONS",
    "SIDES",
    "WHOLE_MUSCLES",
    "MuscleSet",
    "known_muscle_sets",
    "midplane_muscles",
    "muscle_set",
    "muscle_sets",
    "parameter_names",
    "two_sides",
]

SIDES = ("left", "right")

WHOLE_MUSCLES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "masseter": ("superficial_masseter", "deep_masseter"),
        "temporalis": ("anterior_temporalis", "posterior_temporalis"),
        "medial_pterygoid": ("anterior_medial_pterygoid", "posterior_medial_pterygoid"),
    }
)
"""The closing muscles of one side, each with its portions."""

PORTIONS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {portion: (portion,) for portions in WHOLE_MUSCLES.values() for portion in portions}
)
"""The portions of the closing muscles of one side, each a line of its own."""


def _sided(groups: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    return tuple(f"{group}_{side}" for side in SIDES for group in groups)


def parameter_names(muscles: Sequence[str]) -> tuple[str, ...]:
    """Names of the parameters of muscles in order: log F_o and log b of each."""
    return tuple(f"{symbol}/{muscle}" for muscle in muscles for symbol in ("log_F_o", "log_b"))


MUSCLE_NAMES = _sided(WHOLE_MUSCLES)
PARAMETER_NAMES = parameter_names(MUSCLE_NAMES)


@dataclass(frozen=True, eq=False)
class MuscleSet(FrozenArrays):
    """Lines of action of n lines that belong to m muscles, jaw closed.

    The frame's origin lies midway between the condyle centres, x forward, y left, z up.
    """

    names: tuple[str, ...]  # m muscles, left side first
    muscle: tuple[int, ...]  # n indices: which muscle a line belongs to
    origin_m: NDArray[np.float64]  # (n, 3) ends on the skull
    insertion_m: NDArray[np.float64]  # (n, 3) ends on the mandible, jaw closed
    l_o_m: NDArray[np.float64]  # (n,) closed-jaw lengths, to which `F_o` belongs
    origin_sd_m: NDArray[np.float64]  # (n, 3) sd between subjects of the ends on the skull
    insertion_sd_m: NDArray[np.float64]  # (n, 3) the same of the ends on the mandible

    def __post_init__(self) -> None:
        """Check the shapes, that every muscle has a line and that no line has lost its length."""
        super().__post_init__()
        n = len(self.muscle)
        for name in ("origin_m", "insertion_m", "origin_sd_m", "insertion_sd_m"):
            self._require_shape(name, (n, 3))
        self._require_shape("l_o_m", (n,))
        if sorted(set(self.muscle)) != list(range(len(self.names))):
            raise InputError(f"muscle is {self.muscle}; allowed: a line for each of {len(self.names)} muscles")
        for muscle, l_o in zip(self.muscle, self.l_o_m, strict=True):
            if l_o <= 0:
                raise InputError(f"l_o_m of {self.names[muscle]} is {l_o}; allowed: numbers above 0")

    def __len__(self) -> int:
        """Number of muscles m."""
        return len(self.names)

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of the 2 m parameters: log F_o and log b of each muscle."""
        return parameter_names(self.names)

    @property
    def whole_muscles_per_line(self) -> float:
        """Number of whole muscles, of the six, that one line stands for; its F_o is multiplied by it."""
        return len(MUSCLE_NAMES) / len(self.muscle)


LineOf = Callable[[str, str], Attachment]
"""The line of a portion on a side."""


def _mean_line(portions: Sequence[str], side: str, line_of: LineOf = attachment) -> Attachment:
    """Force-weighted mean line of some portions of one side; the portions' ends vary independently of each other."""
    lines = [line_of(portion, side) for portion in portions]
    weights = np.array([line.strength_N for line in lines])
    shares = weights[:, np.newaxis] / weights.sum()
    return Attachment(
        origin_m=np.average([line.origin_m for line in lines], axis=0, weights=weights),
        insertion_m=np.average([line.insertion_m for line in lines], axis=0, weights=weights),
        origin_sd_m=np.linalg.norm(shares * [line.origin_sd_m for line in lines], axis=0),
        insertion_sd_m=np.linalg.norm(shares * [line.insertion_sd_m for line in lines], axis=0),
        strength_N=weights.sum(),
    )


def _assemble(names: Sequence[str], muscle: Sequence[int], lines: Sequence[Attachment]) -> MuscleSet:
    origin_m, insertion_m = np.array([line.origin_m for line in lines]), np.array([line.insertion_m for line in lines])
    return MuscleSet(
        names=tuple(names),
        muscle=tuple(muscle),
        origin_m=origin_m,
        insertion_m=insertion_m,
        l_o_m=np.linalg.norm(insertion_m - origin_m, axis=1),
        origin_sd_m=np.array([line.origin_sd_m for line in lines]),
        insertion_sd_m=np.array([line.insertion_sd_m for line in lines]),
    )


def _sided_lines(groups: tuple[tuple[str, tuple[str, ...]], ...], line_of: LineOf) -> MuscleSet:
    names = _sided(dict(groups))
    lines = [_mean_line(portions, side, line_of) for side in SIDES for _, portions in groups]
    return _assemble(names, range(len(names)), lines)


@cache
def _known_lines(groups: tuple[tuple[str, tuple[str, ...]], ...]) -> MuscleSet:
    return _sided_lines(groups, attachment)


def muscle_set(groups: Mapping[str, Sequence[str]] = WHOLE_MUSCLES, line_of: LineOf = attachment) -> MuscleSet:
    """The muscles of both sides, left first, one line each.

    Args:
        groups: muscle name -> its portions. `WHOLE_MUSCLES` gives the 6 lines of the 12-parameter model (the
            line of a whole muscle is the force-weighted mean of its portions' origins and insertions),
            `PORTIONS` the 12 lines of the portions themselves.
        line_of: where a portion is attached; the table by default.
    """
    for group, portions in groups.items():
        if not portions:
            raise InputError(f"muscle '{group}' has no portions; it needs at least one")
    key = tuple((group, tuple(portions)) for group, portions in groups.items())
    return _known_lines(key) if line_of is attachment else _sided_lines(key, line_of)


def two_sides(line_of: LineOf = attachment) -> MuscleSet:
    """The six whole muscles' lines with one stiffness on each side: 4 parameters."""
    sides = [side for side in range(len(SIDES)) for _ in WHOLE_MUSCLES]
    lines = [_mean_line(portions, side, line_of) for side in SIDES for portions in WHOLE_MUSCLES.values()]
    return _assemble(SIDES, sides, lines)


def midplane_muscles(groups: Mapping[str, Sequence[str]] = WHOLE_MUSCLES, line_of: LineOf = attachment) -> MuscleSet:
    """Each pair of muscles as one line in the sagittal plane, the mean of left and right."""
    lines = []
    for portions in groups.values():
        left, right = (_mean_line(portions, side, line_of) for side in SIDES)
        # Left and right vary independently, so the sd of their mean is smaller.
        flat, flat_sd = np.array([0.5, 0.0, 0.5]), np.array([0.5, 0.0, 0.5]) ** 0.5
        lines.append(
            Attachment(
                origin_m=flat * (left.origin_m + right.origin_m),
                insertion_m=flat * (left.insertion_m + right.insertion_m),
                origin_sd_m=flat_sd * _mean_sd(left.origin_sd_m, right.origin_sd_m),
                insertion_sd_m=flat_sd * _mean_sd(left.insertion_sd_m, right.insertion_sd_m),
                strength_N=left.strength_N + right.strength_N,
            )
        )
    return _assemble(tuple(groups), range(len(groups)), lines)


def _mean_sd(left: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
    """Root of the mean variance of two sides; to the bit that of one where they are alike."""
    mean: NDArray[np.float64] = np.where(left == right, left, np.sqrt(0.5 * (left**2 + right**2)))
    return mean


def muscle_sets(line_of: LineOf = attachment) -> Mapping[str, MuscleSet]:
    """The muscle sets of the models by name, the default one first, with portions attached as ``line_of`` says."""
    return MappingProxyType(
        {
            "whole": muscle_set(line_of=line_of),
            "closers": midplane_muscles({"closers": tuple(PORTIONS)}, line_of),
            "pairs": midplane_muscles(line_of=line_of),
            "sides": two_sides(line_of),
            "portions": muscle_set(PORTIONS, line_of),
        }
    )


@cache
def known_muscle_sets() -> Mapping[str, MuscleSet]:
    """The muscle sets of the models by name, the default one first."""
    return muscle_sets()
