"""A jaw of one's own: what of attachments, mandible and fossa differs from the default anatomy."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy.attachments import Attachment, attachment
from jawenv.anatomy.mandible import Fossa, Mandible, default_fossa, default_mandible
from jawenv.anatomy.muscles import PORTIONS, SIDES, MuscleSet, muscle_sets
from jawenv.base.errors import InputError, shown
from jawenv.base.files import Source, instance_of, read_into
from jawenv.base.numeric_fields import real_number

__all__ = ["Anatomy", "anatomy_of"]

FARTHEST_M = 0.5
"""Largest distance of a point from the condyles, along each axis."""

RANGES = MappingProxyType(
    {
        "mass_kg": (0.01, 5.0),
        "damping_rotation": (0.0, 10.0),
        "damping_sliding": (0.0, 1000.0),
        "tooth_stiffness": (100.0, 1e6),
        "closing_tone_N": (0.0, 10.0),
        "condyle_half_width_m": (0.005, 0.2),
        "disc_stiffness": (100.0, 1e7),
        "disc_damping": (0.0, 1e4),
        "gravity": (0.0, 30.0),
        "drop_m": (5e-4, 0.02),
        "spatial_frequency": (50.0, 2000.0),
        "strength_N": (1e-3, 1e4),
    }
)
"""Least and largest value of the numbers that are no points, in the units of their classes."""

# N m s2 per kg: moments of inertia lie between those of bodies whose mass is 1 mm and 20 cm from its centre.
INERTIA_PER_KG = (1e-6, 0.04)


@dataclass(frozen=True, eq=False)
class Anatomy:
    """Attachments, mandible and fossa.

    Raises:
        InputError: an unknown portion, a value that is not allowed, or a line without length.
    """

    attachments: Mapping[str, Attachment] = field(default_factory=dict)
    """Portion -> its line on the right, mirrored to the left; portion and side, as ``deep_masseter_left``, -> the
    line of that side alone, with its own y. Other portions have the lines of the table.
    """
    mandible: Mandible = field(default_factory=default_mandible)
    """Mass properties, contact points and damping."""
    fossa: Fossa = field(default_factory=default_fossa)
    """The condyles' path."""

    def __post_init__(self) -> None:
        """Check all numbers, and that the muscles of every model exist."""
        names = [*PORTIONS, *(f"{portion}_{side}" for side in SIDES for portion in PORTIONS)]
        for name, line in self.attachments.items():
            if name not in names:
                allowed = f"{', '.join(PORTIONS)}, each also with _left or _right"
                raise InputError(f"anatomy.attachments.{name} is unknown; allowed: {allowed}")
            _check(f"attachments.{name}", line)
        _check("mandible", self.mandible)
        _check("fossa", self.fossa)
        moments = np.linalg.eigvalsh(self.mandible.inertia_kg_m2) / self.mandible.mass_kg
        low, high = INERTIA_PER_KG
        if not (low <= moments[0] and moments[-1] <= high):
            raise InputError(
                f"anatomy.mandible.inertia_kg_m2 has principal moments of {moments[0]:g} to {moments[-1]:g} m2 per kg; "
                f"allowed: {low:g} to {high:g}"
            )
        object.__setattr__(self, "attachments", MappingProxyType(dict(self.attachments)))
        self.muscle_sets()

    def __reduce__(self) -> tuple[Any, ...]:
        """Rebuild through the constructor: a mapping that is only read cannot be pickled."""
        return type(self), (dict(self.attachments), self.mandible, self.fossa)

    def line_of(self, portion: str, side: str) -> Attachment:
        """The line of a portion on one side."""
        own = self.attachments.get(f"{portion}_{side}")
        if own is not None:
            return own
        right = self.attachments.get(portion)
        if right is None:
            return attachment(portion, side)
        mirror = np.array([1.0, -1.0 if side == "left" else 1.0, 1.0])
        return replace(right, origin_m=mirror * right.origin_m, insertion_m=mirror * right.insertion_m)

    def muscle_sets(self) -> Mapping[str, MuscleSet]:
        """The muscle sets of the models by name, as ``known_muscle_sets``, with these attachments."""
        return muscle_sets(self.line_of)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """The default anatomy with a mapping's changes; names and units are those of the classes' fields.

        Args:
            data: ``attachments``, ``mandible`` and ``fossa``, each a mapping and each left out where nothing differs.

        Raises:
            InputError: an unknown name, or what the classes refuse.
        """
        for name in data:
            if name not in ("attachments", "mandible", "fossa"):
                raise InputError(f"anatomy.{name} is not a field of Anatomy; allowed: attachments, mandible, fossa")
        lines = {}
        for name, change in _mapping(data.get("attachments"), "attachments").items():
            portion, side = _portion(name)
            lines[name] = _changed(attachment(portion, side), change, f"attachments.{name}")
        return cls(
            lines,
            _changed(default_mandible(), data.get("mandible"), "mandible"),
            _changed(default_fossa(), data.get("fossa"), "fossa"),
        )

    def to_dict(self) -> dict[str, Any]:
        """A mapping for ``from_dict``: the fields that differ from the default anatomy's."""
        own = _numbers_of(self)
        usual = {name: attachment(*_portion(name)) for name in self.attachments}
        default = _numbers_of(Anatomy(usual))
        changed = {
            name: {key: value for key, value in numbers.items() if value != default[name][key]}
            for name, numbers in own.items()
        }
        lines = {name: changed[name] for name in self.attachments}
        parts = {"attachments": lines, "mandible": changed["mandible"], "fossa": changed["fossa"]}
        return {name: part for name, part in parts.items() if part}

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """The anatomy of a JSON, TOML or YAML file with the mapping that ``from_dict`` takes.

        Raises:
            InputError: one line that names the file and what is wrong with it.
        """
        return read_into(path, cls.from_dict)

    def __eq__(self, other: object) -> bool:
        """Whether all numbers are the same."""
        return isinstance(other, Anatomy) and _numbers_of(self) == _numbers_of(other)

    def __hash__(self) -> int:
        """Hash of all numbers."""
        return hash(repr(_numbers_of(self)))


def anatomy_of(anatomy: Anatomy | Source | None) -> Anatomy:
    """An anatomy that is given as itself, as a mapping or as the path of a file; None is the default one."""
    return Anatomy() if anatomy is None else instance_of(Anatomy, anatomy, "anatomy")


def _portion(name: str) -> tuple[str, str]:
    """Portion and side of a key of ``attachments``; the right side where it names none."""
    for side in SIDES:
        portion = str(name).removesuffix(f"_{side}")
        if portion != name and portion in PORTIONS:
            return portion, side
    if name not in PORTIONS:
        allowed = f"{', '.join(PORTIONS)}, each also with _left or _right"
        raise InputError(f"anatomy.attachments.{name} is unknown; allowed: {allowed}")
    return str(name), "right"


def _mapping(value: object, where: str) -> Mapping[str, Any]:
    if value is None:
        return {}
    if not isinstance(value, Mapping):
        raise InputError(f"anatomy.{where} is {shown(value)}; allowed: a mapping")
    return value


def _changed(default: Any, change: object, where: str) -> Any:
    """An object with the fields that a mapping names."""
    names = [entry.name for entry in fields(default)]
    changes = _mapping(change, where)
    for name in changes:
        if name not in names:
            raise InputError(f"anatomy.{where}.{name} is not a field; allowed: {', '.join(names)}")
    try:
        return replace(default, **changes) if changes else default
    except InputError as error:
        raise InputError(f"anatomy.{where}: {error}") from None


def _check(where: str, part: Any) -> None:
    """Check that numbers are in range, and points within reach."""
    for entry in fields(part):
        value = getattr(part, entry.name)
        if entry.name in RANGES:
            low, high = RANGES[entry.name]
            number = real_number(value)
            if number is None or not low <= number <= high:
                raise InputError(f"anatomy.{where}.{entry.name} is {shown(value)}; allowed: {low:g} to {high:g}")
        elif entry.name.endswith("_m"):
            shape = (3, 3) if entry.name == "teeth_m" else (3,)
            least = 0.0 if "sd" in entry.name else -FARTHEST_M
            points: NDArray[np.float64] = np.asarray(value)
            if points.shape != shape or not ((points >= least) & (points <= FARTHEST_M)).all():
                allowed = f"numbers of shape {shape}, {least:g} to {FARTHEST_M:g} m"
                raise InputError(f"anatomy.{where}.{entry.name} is {shown(points.tolist())}; allowed: {allowed}")


def _numbers_of(anatomy: Anatomy) -> dict[str, Any]:
    parts: dict[str, Any] = {**anatomy.attachments, "mandible": anatomy.mandible, "fossa": anatomy.fossa}
    return {
        name: {entry.name: np.asarray(getattr(part, entry.name)).tolist() for entry in fields(part)}
        for name, part in sorted(parts.items())
    }
