"""Frozen dataclasses whose arrays are frozen too."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from jawenv.base.errors import InputError

__all__ = ["FrozenArrays"]


class FrozenArrays:
    """Base of frozen dataclasses of numbers: arrays become float64 copies, read-only, also after unpickling.

    Tuples of names or of whole numbers stay as they are.
    """

    def __post_init__(self) -> None:
        """Replace every array by a read-only float64 copy."""
        for field in fields(self):  # type: ignore[arg-type]
            value = getattr(self, field.name)
            if _is_names_or_indices(value):
                continue
            try:
                number = np.array(value, dtype=np.float64)
            except (TypeError, ValueError):
                raise InputError(f"{field.name} is {value!r}; allowed: numbers") from None
            if not np.all(np.isfinite(number)):
                raise InputError(f"{field.name} is {number.tolist()}; allowed: finite numbers")
            number.setflags(write=False)
            object.__setattr__(self, field.name, float(number) if number.ndim == 0 else number)

    def __reduce__(self) -> tuple[Any, ...]:
        """Rebuild through the constructor: plain unpickling would leave the arrays writable."""
        return type(self), tuple(getattr(self, field.name) for field in fields(self))  # type: ignore[arg-type]

    def _require_shape(self, name: str, shape: tuple[int, ...]) -> None:
        value = getattr(self, name)
        if np.shape(value) != shape:
            raise InputError(f"{name} has shape {np.shape(value)}; allowed: {shape}")


def _is_names_or_indices(value: object) -> bool:
    return isinstance(value, tuple) and len(value) > 0 and all(isinstance(entry, str | int) for entry in value)
