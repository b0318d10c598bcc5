"""Numbers from outside, and settings that are numbers: each field says once its default, its range and its unit."""

from __future__ import annotations

import math
import numbers
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from jawenv.base.errors import InputError, meant, shown
from jawenv.base.files import read_into


def real_number(value: object) -> float | None:
    """A finite real number as a float; None for anything else, such as a bool, a complex number, text or NaN."""
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def whole_number(value: object) -> int | None:
    """An integer as an int; None for anything else, such as a bool or 2.0."""
    if isinstance(value, bool) or not isinstance(value, numbers.Integral):
        return None
    return int(value)


_TO_SI = {"mm": (1.0, 1e3), "mm/s": (1.0, 1e3), "ms": (1.0, 1e3), "deg": (math.pi / 180.0, 1.0)}
"""Factor and divisor of a unit, from it to SI units."""


class _NumericField(NamedTuple):
    """A field's range and unit."""

    high: float  # the highest value
    unit: str  # such as ``mm/s``; the field's name ends with it, except where it is ``1``
    zero: bool  # whether 0 is allowed, by which some formulas divide
    record: str | None  # name in the kernels' record; None for the field's without its unit

    def allowed(self) -> str:
        """The range in words."""
        return f"a finite number, {'0 or more' if self.zero else 'more than 0'}, at most {self.high:g}"

    def accepts(self, number: float | None) -> bool:
        """Whether a number is in the range."""
        return number is not None and 0.0 <= number <= self.high and (self.zero or number > 0.0)


def number(default: float, high: float, unit: str, *, zero: bool = True, record: str | None = None) -> Any:
    """A field of `NumericFields`; see `NumericField`."""
    return field(default=default, metadata={"number": _NumericField(high, unit, zero, record)})


@dataclass(frozen=True)
class NumericFields:
    """Numbers from outside, each in its range."""

    def __post_init__(self) -> None:
        """Check every field."""
        for name, kind in self.numeric_fields().items():
            value = getattr(self, name)
            real = real_number(value)
            if not kind.accepts(real):
                raise InputError(f"{self._called()}.{name} is {shown(value)}; allowed: {kind.allowed()}")
            object.__setattr__(self, name, real)

    @classmethod
    def numeric_fields(cls) -> dict[str, _NumericField]:
        """Range and unit of each field."""
        return {entry.name: entry.metadata["number"] for entry in fields(cls)}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """The fields that a mapping names; the others have their defaults."""
        allowed = cls.numeric_fields()
        for name in data:
            if name not in allowed:
                wrong, names = f"{cls._called()}.{shown(name)[1:-1]}", ", ".join(allowed)
                near = meant(str(name), allowed)
                raise InputError(f"{wrong} is not a field of {cls.__name__}; {near}allowed: {names}")
        return cls(**data)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """The fields that a JSON, TOML or YAML file names."""
        return read_into(path, cls.from_dict)

    def changes(self) -> dict[str, float]:
        """The fields that differ from their defaults, as ``from_dict`` takes them."""
        return {
            entry.name: getattr(self, entry.name)
            for entry in fields(self)
            if getattr(self, entry.name) != entry.default
        }

    def in_si(self) -> dict[str, float]:
        """All numbers in SI units, by their names in the kernels' record."""
        numbers = {}
        for name, kind in self.numeric_fields().items():
            times, by = _TO_SI.get(kind.unit, (1.0, 1.0))
            ending = "_" + kind.unit.replace(" ", "_").replace("/", "_")
            numbers[kind.record or name.removesuffix(ending)] = times * getattr(self, name) / by
        return numbers

    def fill(self, records: npt.NDArray[np.void]) -> None:
        """Write the numbers, in SI units, into the fields of kernels' records that have their names."""
        for name, value in self.in_si().items():
            if name in (records.dtype.names or ()):
                records[name] = value

    @classmethod
    def _called(cls) -> str:
        return cls.__name__.lower()
