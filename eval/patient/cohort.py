"""A cohort whose prior is what earlier treatments have told of one of its patients."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jawenv.anatomy import Cohort, Prior


@dataclass(frozen=True, eq=False, kw_only=True)
class KnownPatient(Cohort):
    """The cohort of a patient, with another prior for the filter.

    Attributes:
        believed: the prior.
    """

    believed: Prior

    def __post_init__(self) -> None:
        """Put the prior in place of the cohort's own.

        Raises:
            InputError: what `Cohort` refuses.
        """
        super().__post_init__()
        object.__setattr__(self, "_typical", self.prior.mean)
        object.__setattr__(self, "prior", self.believed)

    @property
    def typical(self) -> NDArray[np.float64]:
        """Those of the cohort, so that the filter has as many numbers to integrate out whatever is believed."""
        typical: NDArray[np.float64] = self.__dict__["_typical"]
        return typical

    @classmethod
    def of(cls, cohort: Cohort, believed: Prior) -> KnownPatient:
        """A cohort with another prior."""
        return cls(cohort.name, cohort.description, cohort.basis, cohort.groups, cohort.muscles, believed=believed)

    def __reduce__(self) -> tuple[Any, ...]:
        """Rebuild with the prior."""
        return KnownPatient.of, (Cohort(self.name, self.description, self.basis, self.groups, self.muscles), self.prior)
