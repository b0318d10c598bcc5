"""The surface along which the condyle slides."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from jawenv.anatomy.arrays import FrozenArrays
from jawenv.anatomy.quantities import load_quantities
from jawenv.base.errors import InputError

__all__ = ["Fossa", "default_fossa"]


@dataclass(frozen=True)
class Fossa(FrozenArrays):
    """The condyle centre's path `z = d (cos f x - 1)`, from the roof of the fossa over the eminence."""

    drop_m: float  # d; the crest of the eminence lies 2 d below the roof
    spatial_frequency: float  # f, rad/m; the crest lies at x = pi/f

    def __post_init__(self) -> None:
        """Check that there is a path."""
        super().__post_init__()
        for name in ("drop_m", "spatial_frequency"):
            self._require_shape(name, ())
            if getattr(self, name) <= 0:
                raise InputError(f"{name} is {getattr(self, name)}; allowed: numbers above 0")

    @property
    def crest_m(self) -> float:
        """The crest of the eminence, where the path is lowest: its x."""
        return float(np.pi / self.spatial_frequency)


@cache
def default_fossa() -> Fossa:
    """The adult fossa of the data file `fossa.toml`."""
    quantities = load_quantities("fossa.toml")
    return Fossa(float(quantities["drop"].si()), float(quantities["spatial_frequency"].si()))
