"""The same motion measured again: Young (2016), figs. 6.3-6.6, takes 1,000 draws of noise on one trajectory."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from jawenv.errors import InputError
from jawenv.estimation.recordings.record import Record
from jawenv.estimation.thesis_methods.inverse_kinematics import expected_measurements

Array = NDArray[np.float64]


def redraw(record: Record, rng: np.random.Generator, cell_sd: Array) -> Record:
    """A record of the same true motion and wrench, with new noise of encoders and load cell and a new gain error.

    What no model explains, the unmodelled wrench, has acted on the motion and is the same in all draws: their spread
    is that of the measurement's noise alone, less than the error of an estimate on a new episode. A mouthpiece that
    left the fossa's path, a load cell's offset and encoders' play are not in a record's truth and not in its redraw.

    Args:
        record: of the midline model, with ``states`` and ``wrenches``.
        rng: of the noise.
        cell_sd: (6,) noise of one load-cell sample: force (N), moment (N m).

    Raises:
        InputError: the record has no truth to measure, or ``cell_sd`` a wrong shape.
    """
    if record.states is None or record.wrenches is None:
        raise InputError("record has no true states and wrenches, allowed are records that have them: simulated ones")
    if np.shape(cell_sd) != (6,):
        raise InputError(f"cell_sd has shape {np.shape(cell_sd)}, allowed is (6,)")
    expected, _, _ = expected_measurements(record.jaw, record.states)
    measured = expected + record.measurement_sd * rng.standard_normal(expected.shape)
    measured[np.isnan(record.measured)] = np.nan
    gain = record.gain_sd * rng.standard_normal()
    samples = record.wrenches / (1.0 + gain) + cell_sd * rng.standard_normal(record.wrenches.shape)
    return replace(record, measured=measured, samples=samples)
