"""Which of the numbers that are known only within sds are the patient's own, and which those of a session.

A patient who comes again has the same attachments, fossa, mass, centre of mass, inertia and damping. Tilt of the head,
place and turn of the mouthpiece, offset and axes of the load cell are others.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jawenv.mechanics.unknowns import Unknowns, with_inertial

OWN_NUMBERS = 5
"""The first of ``Unknowns.numbers``: drop and frequency of the fossa, mass, both dampings; then the session's tilt."""


def with_anatomy_of(patient: Unknowns, session: Unknowns) -> Unknowns:
    """The patient's own values of one, and the session's of another."""
    numbers = np.concatenate([patient.numbers[:OWN_NUMBERS], session.numbers[OWN_NUMBERS:]])
    joined = session._replace(
        origin=patient.origin,
        insertion=patient.insertion,
        numbers=numbers,
        centre_of_mass=patient.centre_of_mass,
        inertia=patient.inertia,
    )
    return with_inertial(joined)


def own_values(values: Unknowns) -> NDArray[np.float64]:
    """(8 + 6 lines,) the patient's own values, in prior sds: numbers, centre of mass, ends of each line."""
    ends = np.hstack([values.origin, values.insertion])
    return np.concatenate([values.numbers[:OWN_NUMBERS], values.centre_of_mass, ends.ravel()])
