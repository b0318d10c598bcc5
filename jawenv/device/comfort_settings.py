"""The numbers of comfort: what is allowed of any patient, of which a patient's own limits are made at rest.

All are proposals (grade G, or D where they are derived from the means of healthy adults), to be replaced by a
clinician's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.base.files import instance_of
from jawenv.base.numeric_fields import NumericFields, number
from jawenv.device.comfort import COMFORT, COMFORT_LIMITS
from jawenv.kernels.records import record_zeros

__all__ = ["COMFORT", "Comfort", "comfort_of"]

LEAST_HARD = 1.05  # over the soft limit: the cost grows from 0 to 1 between them, and the governor needs room
SMALLEST_RANGE_MM = 5.0  # of a patient whom the device can treat: a painless range below is none


@dataclass(frozen=True)
class Comfort(NumericFields):
    """A patient's limits of comfort, and the multiple of them that ends an episode."""

    force_N: float = number(24.0, 1000.0, "N", zero=False)
    """Soft limit of the force of the device on the mouthpiece (G)."""
    speed_mm_s: float = number(40.0, 10000.0, "mm/s", zero=False)
    """Soft limit of the mouthpiece's speed (G)."""
    condyle_side_mm: float = number(3.0, 100.0, "mm", zero=False)
    """Soft limit of the condyles' travel to a side, from rest (G)."""
    side_mm: float = number(10.0, 100.0, "mm", zero=False)
    """Soft limit of the mouthpiece's travel to a side, of a jaw that opens 48 mm; in proportion with less (D)."""
    fore_aft_mm: float = number(8.8, 100.0, "mm", zero=False)
    """Soft limit of the mouthpiece's travel off the natural path, alike (D)."""
    painless_force_N: float = number(20.0, 1000.0, "N", zero=False)
    """Vertical pull that ends the painless range, the soft limit of opening (G)."""
    painless_range_mm: float = number(35.0, 60.0, "mm", zero=False)
    """Largest painless range, above rest (G)."""
    largest_opening_mm: float = number(45.0, 60.0, "mm", zero=False)
    """Largest opening at the end of the painless range, in all (G)."""
    condyle_back_mm: float = number(0.5, 100.0, "mm")
    """How far behind the fossa's roof the middle of the condyles may go (G)."""
    condyle_free_mm: float = number(2.0, 100.0, "mm")
    """How far the condyles may go beyond their natural travel (G)."""
    tension_margin: float = number(1.5, 1000.0, "1", zero=False)
    """Soft limit of a muscle's tension, over that at the end of the painless range (G)."""
    force_hard: float = number(1.5, 1000.0, "1", zero=False)
    """Hard limit over soft limit, of the force (G)."""
    opening_hard: float = number(1.3, 1000.0, "1", zero=False)
    """Hard limit of the opening over its soft limit (G)."""
    side_hard: float = number(1.8, 1000.0, "1", zero=False)
    """Hard limit of the mouthpiece's travel to a side over its soft limit (G)."""
    fore_aft_hard: float = number(1.8, 1000.0, "1", zero=False)
    """Hard limit of the mouthpiece's travel off the natural path over its soft limit (G)."""
    condyle_fore_aft_hard: float = number(1.4, 1000.0, "1", zero=False)
    """Hard limit of the condyles' travel over its soft limit (G)."""
    condyle_side_hard: float = number(2.0, 1000.0, "1", zero=False)
    """Hard limit of the condyles' travel to a side over its soft limit (G)."""
    speed_hard: float = number(5.0, 1000.0, "1", zero=False)
    """Hard limit of the speed over its soft limit (G)."""
    tension_hard: float = number(2.5, 1000.0, "1", zero=False)
    """Hard limit of the tension over its soft limit (G)."""

    def __post_init__(self) -> None:
        """Check that hard limits lie beyond soft ones, and that a painless range is wide enough to be one.

        Raises:
            InputError: they do not.
        """
        super().__post_init__()
        for name in COMFORT_LIMITS:
            hard = getattr(self, f"{name}_hard")
            if hard < LEAST_HARD:
                raise InputError(
                    f"comfort.{name}_hard is {hard:g}; allowed: {LEAST_HARD:g} or more, over the soft limit"
                )
        for name in ("painless_range_mm", "largest_opening_mm"):
            if getattr(self, name) < SMALLEST_RANGE_MM:
                raise InputError(f"comfort.{name} is {getattr(self, name):g}; allowed: {SMALLEST_RANGE_MM:g} or more")

    def records(self) -> NDArray[np.void]:
        """The numbers as an array of one record of dtype ``COMFORT``, as the kernels read it, in SI units."""
        records, si = record_zeros(1, COMFORT), self.in_si()
        self.fill(records)
        records["hard"] = [si[f"{name}_hard"] for name in COMFORT_LIMITS]
        return records


def comfort_of(comfort: object) -> Comfort:
    """Comfort that is given as itself, as a mapping of fields or as the path of a file; None is the default one."""
    return Comfort() if comfort is None else instance_of(Comfort, comfort, "comfort")
