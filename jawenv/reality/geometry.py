"""A patient whose geometry differs from the filter's model."""

from __future__ import annotations

from math import exp, pi
from typing import Any

import numpy as np

from jawenv.anatomy.muscles import MuscleSet
from jawenv.reality.options import Reality


def perturb_geometry(reality: Reality, muscles: MuscleSet, jaw: Any, generator: np.random.Generator) -> None:
    """Move the true jaw's muscle ends and reshape its fossa, at random; draws nothing when both errors are 0.

    Each coordinate of each end of each line has an independent normal error with the line's own sd, so left and right
    differ. ``l_o`` becomes the new closed-jaw length: F_o is still the force there. Drop and spatial frequency of
    the fossa are multiplied by independent log-normal factors, and the crest moves with the frequency.

    Args:
        reality: ``attachment_error`` and ``fossa_error`` are used.
        muscles: The lines' means and sds.
        jaw: The truth's record, dtype ``jaw_dtype(number of lines)``; changed in place.
        generator: Source of the errors; the order of draws is the same whichever error is 0.
    """
    if not reality.moves_geometry:
        return
    drop, frequency = (float(normal) for normal in generator.standard_normal(2))
    origin_normals, insertion_normals = generator.standard_normal((2, *muscles.origin_m.shape))
    if reality.fossa_error > 0.0:
        jaw["fossa_drop"] *= exp(reality.fossa_error * drop)
        jaw["fossa_frequency"] *= exp(reality.fossa_error * frequency)
        jaw["crest"] = pi / jaw["fossa_frequency"]
    if reality.attachment_error > 0.0:
        jaw["origin"] += reality.attachment_error * muscles.origin_sd_m * origin_normals
        jaw["insertion"] += reality.attachment_error * muscles.insertion_sd_m * insertion_normals
        jaw["l_o"] = np.linalg.norm(jaw["insertion"] - jaw["origin"], axis=1)
