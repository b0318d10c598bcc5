"""A patient: how stiff each closing muscle is, and how the head is held."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Annotated, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import AfterValidator, Field

from jawenv.anatomy.muscles import MUSCLE_NAMES, PARAMETER_NAMES
from jawenv.errors import InputError
from jawenv.files import InputModel, Number, read_model, validate, write_json

__all__ = ["Patient"]


def _of_all_muscles(values: dict[str, float]) -> dict[str, float]:
    """The same values in the order of MUSCLE_NAMES, exactly one per muscle."""
    for name in values:
        if name not in MUSCLE_NAMES:
            raise ValueError(f"unknown muscle '{name}'; allowed: {', '.join(MUSCLE_NAMES)}")
    for name in MUSCLE_NAMES:
        if name not in values:
            raise ValueError(f"muscle '{name}' is missing; needed: {', '.join(MUSCLE_NAMES)}")
    return {name: values[name] for name in MUSCLE_NAMES}


class Patient(InputModel):
    """The muscle law `F = F_o exp(b (l - l_o)/l_o)` of the six closing muscles, and the tilt of the head.

    Attributes:
        name: for tables and files.
        F_o_N: muscle -> force at its closed-jaw length, N, in (0, 100].
        b: muscle -> stiffness exponent, in (0, 60].
        head_tilt_deg: pitch of the head, positive nose down, in [-90, 90].

    Raises:
        InputError: one line that names the field, the value and what is allowed.
    """

    name: str = Field(default="patient", min_length=1)
    F_o_N: Annotated[dict[str, Annotated[Number, Field(gt=0, le=100)]], AfterValidator(_of_all_muscles)]
    b: Annotated[dict[str, Annotated[Number, Field(gt=0, le=60)]], AfterValidator(_of_all_muscles)]
    head_tilt_deg: Annotated[Number, Field(ge=-90, le=90)] = 0.0

    @classmethod
    def from_dict(cls, data: Mapping[str, object]) -> Self:
        """A patient from a mapping of the fields.

        Raises:
            InputError: as the constructor, and for something that is not a mapping.
        """
        return validate(cls, data, cls.__name__)

    @classmethod
    def from_log_parameters(cls, theta: ArrayLike, *, name: str = "patient", head_tilt_deg: float = 0.0) -> Self:
        """A patient from natural-log parameters, (12,) in the order of `PARAMETER_NAMES`.

        Raises:
            InputError: wrong shape, not finite, or a muscle out of range.
        """
        try:
            values = np.asarray(theta, dtype=np.float64)
        except (TypeError, ValueError):
            raise InputError("log parameters must be numbers") from None
        if values.shape != (len(PARAMETER_NAMES),):
            raise InputError(f"log parameters have shape {values.shape}, must be ({len(PARAMETER_NAMES)},)")
        for parameter, value in zip(PARAMETER_NAMES, values, strict=True):
            if not np.isfinite(value):
                raise InputError(f"{parameter} = {value} must be finite")
        with np.errstate(over="ignore"):
            F_o, b = np.exp(values[0::2]), np.exp(values[1::2])
        data = {
            "name": name,
            "F_o_N": dict(zip(MUSCLE_NAMES, F_o.tolist(), strict=True)),
            "b": dict(zip(MUSCLE_NAMES, b.tolist(), strict=True)),
            "head_tilt_deg": head_tilt_deg,
        }
        return cls.from_dict(data)

    def log_parameters(self) -> NDArray[np.float64]:
        """Natural logs of F_o (N) and b, (12,) in the order of `PARAMETER_NAMES`."""
        return np.log([value for name in MUSCLE_NAMES for value in (self.F_o_N[name], self.b[name])])

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the patient as JSON; the file appears whole or not at all.

        Raises:
            InputError: the file cannot be written.
        """
        write_json(path, self)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read a patient from a JSON (or TOML, YAML) file.

        Raises:
            InputError: one line that names the file and what is wrong with it.
        """
        return read_model(path, cls)
