"""A patient: how stiff each closing muscle is, and how the head is held."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Annotated, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from jawenv.anatomy.muscles import MUSCLE_NAMES, known_muscle_sets, parameter_names
from jawenv.base.errors import InputError, shown
from jawenv.base.files import InputModel, Number, Text, read_model, validate, write_json

__all__ = ["LARGEST_F_O_N", "LARGEST_B", "Patient"]

LARGEST_F_O_N, LARGEST_B, LARGEST_SEED = 200.0, 60.0, 2**32 - 1


def _of_all_muscles(values: dict[str, float]) -> dict[str, float]:
    """The same values in the order of the muscle set that they mean, exactly one per muscle."""
    sets = [muscles.names for muscles in known_muscle_sets().values()]
    names = max(sets, key=lambda names: len(set(values) & set(names)))
    for name in values:
        if name not in names:
            raise ValueError(f"unknown muscle '{name}'; allowed: {', '.join(names)}")
    for name in names:
        if name not in values:
            raise ValueError(f"muscle '{name}' is missing; needed: {', '.join(names)}")
    return {name: values[name] for name in names}


def _pythons(value: object) -> object:
    """NumPy's whole numbers as Python's."""
    return int(value) if isinstance(value, np.integer) else value


class Patient(InputModel):
    """The muscle law `F = F_o exp(b (l - l_o)/l_o)` of the closing muscles, and the tilt of the head.

    The muscles are the six whole ones, or those of another model (`known_muscle_sets`).

    Raises:
        InputError: one line that names the field, the value and what is allowed.
    """

    name: Text = Field(default="patient", min_length=1)
    """For tables and files."""
    F_o_N: Annotated[dict[str, Annotated[Number, Field(gt=0, le=LARGEST_F_O_N)]], AfterValidator(_of_all_muscles)]
    """Muscle -> force at its closed-jaw length, N, in (0, 200]."""
    b: Annotated[dict[str, Annotated[Number, Field(gt=0, le=LARGEST_B)]], AfterValidator(_of_all_muscles)]
    """Muscle -> stiffness exponent, in (0, 60]."""
    head_tilt_deg: Annotated[Number, Field(ge=-90, le=90)] = 0.0
    """Pitch of the head, positive nose down, in [-90, 90]."""
    anatomy_seed: Annotated[int, Field(ge=0, le=LARGEST_SEED), BeforeValidator(_pythons)] | None = None
    """Seed of the anatomy known only within sds (`jawenv.Knowledge`), so that it is the same in all episodes, 0
    to 2**32 - 1; drawn anew in each by default.
    """

    @classmethod
    def from_dict(cls, data: Mapping[str, object]) -> Self:
        """A patient from a mapping of the fields.

        Raises:
            InputError: as the constructor, and for something that is not a mapping.
        """
        return validate(cls, data, cls.__name__)

    @classmethod
    def from_log_parameters(
        cls,
        theta: ArrayLike,
        *,
        name: str = "patient",
        head_tilt_deg: float = 0.0,
        muscles: Sequence[str] = MUSCLE_NAMES,
    ) -> Self:
        """A patient from natural-log parameters of ``muscles``: log F_o and log b of each, in order.

        Raises:
            InputError: wrong shape, not finite, or a muscle out of range.
        """
        try:
            values = np.asarray(theta, dtype=np.float64)
        except (TypeError, ValueError):
            raise InputError(f"log parameters are {shown(theta)}; allowed: numbers") from None
        names = parameter_names(muscles)
        if values.shape != (len(names),):
            raise InputError(f"log parameters have shape {values.shape}; allowed: ({len(names)},)")
        for parameter, value in zip(names, values, strict=True):
            if not np.isfinite(value):
                raise InputError(f"{parameter} is {value}; allowed: finite numbers")
        with np.errstate(over="ignore"):
            F_o, b = np.exp(values[0::2]), np.exp(values[1::2])
        data = {
            "name": name,
            "F_o_N": dict(zip(muscles, F_o.tolist(), strict=True)),
            "b": dict(zip(muscles, b.tolist(), strict=True)),
            "head_tilt_deg": head_tilt_deg,
        }
        return cls.from_dict(data)

    def log_parameters(self) -> NDArray[np.float64]:
        """Natural logs of F_o (N) and b, two of each muscle: (12,) in the order of `PARAMETER_NAMES` by default."""
        return np.log([value for name in self.muscles for value in (self.F_o_N[name], self.b[name])])

    @property
    def muscles(self) -> tuple[str, ...]:
        """Names of the muscles."""
        return tuple(self.F_o_N)

    @model_validator(mode="after")
    def _same_muscles(self) -> Self:
        if tuple(self.b) != tuple(self.F_o_N):
            raise ValueError(f"b is of {', '.join(self.b)}, but F_o_N of {', '.join(self.F_o_N)}")
        return self

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
