"""Geometry, mass and stiffness of one jaw as one record in SI units; ``building`` fills it.

The record's dtype carries the number of lines, and Numba compiles the kernels once for each dtype: the sizes are known
to the compiler, and one source serves every model.
"""

from __future__ import annotations

from functools import cache
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from jawenv.kernels.records import Array, record_dtype

N_TEETH = 3


class Jaw:
    """One jaw, as kernels read it."""

    mass: float
    centre_of_mass: Annotated[Array, 3]
    inertia: Annotated[Array, 3, 3]  # about the centre of mass
    # About the contact point, I - m [rho_c]x [rho_c]x: inverse of the block of the free rotations, zeros elsewhere.
    inertia_contact_inverse: Annotated[Array, 3, 3]
    free_x: bool
    free_y: bool
    gravity: Annotated[Array, 3]  # acceleration in head axes
    fossa_drop: float
    fossa_frequency: float
    damping_rotation: float
    damping_sliding: float
    tooth_stiffness: float
    condyle_stiffness: float
    condyle_half_width: float  # the condyles' centres lie at (0, +-it, 0) in body axes
    disc_stiffness: float  # of each condyle's disc, of MuJoCo's jaw
    disc_damping: float
    stop_width: float
    crest: float  # x of the eminence's crest, where the anterior stop begins
    teeth: Annotated[Array, N_TEETH, 3]
    mouthpiece: Annotated[Array, 3]
    zero: Annotated[Array, 3]  # what the encoders' place is off by, head axes
    origin: Annotated[Array, "lines", 3]
    insertion: Annotated[Array, "lines", 3]
    l_o: Annotated[Array, "lines"]
    tone: float  # N, constant active tension of every line, beside the passive one
    mobility: Annotated[Array, "lines"]  # 1/kg, of the free mandible along a line, jaw closed
    tooth_mobility: Annotated[Array, N_TEETH]  # 1/kg, of the same, straight down at a tooth
    condyle_mobility: float  # 1/kg, of the same, forward at the condyles
    mouthpiece_mobility: float  # 1/kg, of the same, at the mouthpiece in the direction that gives way most
    muscle: Annotated[NDArray[np.int64], "lines"]  # whose F_o and b a line has


@cache
def jaw_dtype(n_lines: int) -> np.dtype[np.void]:
    """Dtype of a jaw with so many muscle lines."""
    return record_dtype(Jaw, lines=n_lines)
