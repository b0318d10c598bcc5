"""Sets of muscle lines: whole muscles or their portions, left and right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy.arrays import FrozenArrays
from jawenv.anatomy.attachments import attachment
from jawenv.errors import InputError

__all__ = [
    "MUSCLE_NAMES",
    "PARAMETER_NAMES",
    "PORTIONS",
    "SIDES",
    "WHOLE_MUSCLES",
    "MuscleSet",
    "muscle_set",
    "parameter_names",
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
    """Lines of action of n muscles, jaw closed.

    The frame's origin lies midway between the condyle centres, x forward, y left, z up.

    Attributes:
        names: n names, left side first.
        origin_m: (n, 3) ends on the skull.
        insertion_m: (n, 3) ends on the mandible, jaw closed.
        l_o_m: (n,) closed-jaw lengths, to which `F_o` belongs.
    """

    names: tuple[str, ...]
    origin_m: NDArray[np.float64]
    insertion_m: NDArray[np.float64]
    l_o_m: NDArray[np.float64]

    def __post_init__(self) -> None:
        """Check the shapes and that no muscle has lost its length."""
        super().__post_init__()
        n = len(self.names)
        self._require_shape("origin_m", (n, 3))
        self._require_shape("insertion_m", (n, 3))
        self._require_shape("l_o_m", (n,))
        for name, l_o in zip(self.names, self.l_o_m, strict=True):
            if l_o <= 0:
                raise InputError(f"l_o_m of {name} = {l_o} must be greater than 0")

    def __len__(self) -> int:
        """Number of muscles n."""
        return len(self.names)


@cache
def _lines(groups: tuple[tuple[str, tuple[str, ...]], ...]) -> MuscleSet:
    origin, insertion = [], []
    for side in SIDES:
        for _, portions in groups:
            lines = [attachment(portion, side) for portion in portions]
            weights = [line.strength_N for line in lines]
            origin.append(np.average([line.origin_m for line in lines], axis=0, weights=weights))
            insertion.append(np.average([line.insertion_m for line in lines], axis=0, weights=weights))
    origin_m, insertion_m = np.array(origin), np.array(insertion)
    return MuscleSet(
        names=_sided(dict(groups)),
        origin_m=origin_m,
        insertion_m=insertion_m,
        l_o_m=np.linalg.norm(insertion_m - origin_m, axis=1),
    )


def muscle_set(groups: Mapping[str, Sequence[str]] = WHOLE_MUSCLES) -> MuscleSet:
    """The muscles of both sides, left first.

    Args:
        groups: muscle name -> its portions. `WHOLE_MUSCLES` gives the 6 lines of the 12-parameter model (the
            line of a whole muscle is the force-weighted mean of its portions' origins and insertions),
            `PORTIONS` the 12 lines of the portions themselves.

    Raises:
        InputError: an unknown portion, or a muscle without portions.
    """
    for group, portions in groups.items():
        if not portions:
            raise InputError(f"muscle '{group}' has no portions; it needs at least one")
    return _lines(tuple((group, tuple(portions)) for group, portions in groups.items()))
