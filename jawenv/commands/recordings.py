"""The command ``jawenv identify``."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from jawenv.laboratory.record_filter import TensionFilter
from jawenv.laboratory.recordings.files import load_record


def identify(path: Path, cohort: str | None, knowledge: str | None) -> None:
    """Print what the environments' filter finds in a recording.

    Raises:
        InputError: the file cannot be read, is damaged, or cohort or knowledge are unknown.
    """
    record = load_record(path, cohort=cohort, knowledge=knowledge)
    found = TensionFilter().estimate(record)
    print(f"{path}: {record.time[-1]:g} s at {1.0 / record.dt:.3g} Hz")
    print(f"{'':32}{'estimate':>10}{'sd':>9}{'truth':>9}")
    for i, name in enumerate(record.parameter_names):
        truth = f"{np.exp(record.truth[i]):9.2f}" if record.truth is not None else f"{'?':>9}"
        sd = 100.0 * found.sd[-1, i]
        print(f"{name.removeprefix('log_'):32}{np.exp(found.mean[-1, i]):10.2f}{sd:7.1f} %{truth}")
