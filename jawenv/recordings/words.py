"""The header of a recording's file: its words, and the values that each may hold."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from jawenv.base.errors import InputError, shown
from jawenv.recordings.table import RecordTable

TEXTS = ("model", "cohort", "control", "force_sensor")
OBJECTS = ("jaw", "anatomy", "device", "knowledge")
NUMBERS: dict[str, tuple[int | str, float, float]] = {
    "head_tilt_deg": (0, -90.0, 90.0),
    "prior_mean": ("parameters", -20.0, 20.0),
    "prior_sd": ("parameters", 1e-6, 20.0),
    "measurement_sd": (12, 1e-12, 1e6),
    "wrench_sd": (6, 1e-12, 1e6),
    "cell_sd": (6, 0.0, 1e6),
    "gain_sd": (0, 0.0, 1.0),
    "start_mean": ("states", -1e6, 1e6),
    "start_sd": ("states", 0.0, 1e6),
    "disturbance_time_s": (0, 0.0, 1e6),
    "disturbance_sd": (6, 0.0, 1e6),
    "truth": ("parameters", -20.0, 20.0),
}
"""Length of a list, 0 for a single number; the least; the largest. SI units, parameters as natural logs."""
WORDS = (*TEXTS, *OBJECTS, *NUMBERS)


def check_texts(table: RecordTable) -> None:
    """Check that names are names, a device is its fields, and a prior is whole."""
    for name in TEXTS:
        if name in table.header and not isinstance(table.header[name], str):
            value = shown(table.header[name])
            raise InputError(f"{table.path}: {name} is {value}; allowed: a name in quotation marks")
    if not isinstance(table.header.get("device", {}), Mapping):
        value = shown(table.header["device"])
        raise InputError(f"{table.path}: device is {value}; allowed: fields of jawenv.Device")
    for name, other in (("prior_mean", "prior_sd"), ("prior_sd", "prior_mean")):
        if name in table.header and other not in table.header:
            raise InputError(f"{table.path}: {name} is given without {other}; allowed: both or neither")


def check_numbers(table: RecordTable, sizes: Mapping[str, int]) -> None:
    """Check shapes, kinds and ranges of the numbers.

    Args:
        table: as read.
        sizes: how many ``states`` and ``parameters`` the model has.
    """
    for name, (size, low, high) in NUMBERS.items():
        if name not in table.header:
            continue
        number = sizes[size] if isinstance(size, str) else size
        try:
            value = np.array(table.header[name])
        except ValueError:  # lists of several lengths
            value = np.array("")
        right = value.dtype.kind in "iuf" and value.shape == ((number,) if number else ())
        if not (right and ((value >= low) & (value <= high)).all()):
            kind = f"a list of {number} finite numbers" if number else "a finite number"
            value_shown = shown(table.header[name])
            raise InputError(f"{table.path}: {name} is {value_shown}; allowed: {kind} from {low:g} to {high:g}")
