"""Anatomical numbers with unit, source and grade, as the data files hold them."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.resources import as_file, files
from types import MappingProxyType
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from jawenv.base.files import InputModel, Number, read_mapping, validate

__all__ = ["Grade", "Quantity", "Unit", "load_quantities", "read_data", "to_si"]

Grade = Annotated[str, Field(pattern=r"^[MADRG](/[MADRG])*$")]
"""M measured, A assumption of a published model, D derived by computation, R recalled, G guess."""

Unit = Literal["kg", "mm", "N", "N/m", "kg m2", "N m s/rad", "N s/m", "rad/m", "m/s2", "1"]

_SI_FACTOR: dict[str, float] = {"mm": 1e-3}


class Quantity(InputModel):
    """A number, a point or a matrix with where it comes from and how far it may be trusted."""

    value: Number | list[Number] | list[list[Number]]
    unit: Unit
    source: str = Field(min_length=1)
    grade: Grade
    range: tuple[Number, Number] | None = None

    def si(self) -> NDArray[np.float64]:
        """The value in SI units, an array of the value's shape."""
        return to_si(self.value, self.unit)


def to_si(value: Number | list[Number] | list[list[Number]], unit: Unit) -> NDArray[np.float64]:
    """A value in SI units, an array of the value's shape."""
    return np.asarray(value, dtype=np.float64) * _SI_FACTOR.get(unit, 1.0)


def read_data(name: str) -> dict[str, object]:
    """The content of one of the package's data files."""
    with as_file(files("jawenv.anatomy") / "data" / name) as path:
        return read_mapping(path)


@cache
def load_quantities(name: str) -> Mapping[str, Quantity]:
    """All quantities of one data file (`mandible.toml`, `fossa.toml`, `strengths.toml`), by name."""
    return MappingProxyType({key: validate(Quantity, data, f"{name}: {key}") for key, data in read_data(name).items()})
