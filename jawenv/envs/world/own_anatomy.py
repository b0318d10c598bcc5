"""Which of the numbers that are known only within sds are the patient's own, and which those of a session.

A patient who comes again has the same attachments, fossa, mass, centre of mass, inertia and damping. Tilt of the head,
place and turn of the mouthpiece, offset and axes of the load cell are others.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jawenv.filter.nuisances.unknowns import ENDS, OWN, UNKNOWNS, Values, with_inertial


def with_anatomy_of(patient: Values, session: Values) -> Values:
    """The patient's own values of one, and the session's of another."""
    return with_inertial(session | {name: patient[name] for name in OWN})


def own_values(values: Values) -> NDArray[np.float64]:
    """(8 + 6 lines,) the patient's own values that the filter is told of, in prior sds; ends of each line last."""
    told = [values[unknown.name] for unknown in UNKNOWNS if unknown.own and unknown.told]
    return np.concatenate([*told, np.hstack([values[name] for name in ENDS]).ravel()])
