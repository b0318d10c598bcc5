"""The filters to calibrate, by their names on the command line."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

from jawenv.base.errors import InputError
from jawenv.recordings.estimate import Estimator
from jawenv.references.extended_kalman import ExtendedKalman
from jawenv.references.filterpy_filters import FilterpyExtendedKalman, FilterpyUnscentedKalman

TENSION = "tension"
"""The environment's own filter: its belief stands in the recording and is not computed again."""
THESIS_RATE = 0.01  # relative, per square root of a second: the constant noise of Young (2016)

Make = Callable[[int], Estimator]
OTHERS: Mapping[str, Make] = MappingProxyType(
    {
        "ekf-decaying": lambda every: ExtendedKalman("log", every=every),
        "ekf-constant": lambda every: ExtendedKalman("log", THESIS_RATE, math.inf, every),
        "ekf-none": lambda every: ExtendedKalman("log", 0.0, every=every),
        "ekf-linear": lambda every: ExtendedKalman("linear", THESIS_RATE, math.inf, every),
        "ekf-filterpy": lambda every: FilterpyExtendedKalman(every=every, compiled_model=True),
        "ukf": lambda every: FilterpyUnscentedKalman(every=every),
    }
)
"""Each by its name: made from the ticks between the kept beliefs."""


def filters_named(names: Sequence[str]) -> tuple[str, ...]:
    """The same names, each once."""
    allowed = (TENSION, *OTHERS)
    for name in names or ("",):
        if name not in allowed:
            raise InputError(f"filters is {name!r}; allowed: {', '.join(allowed)}")
    return tuple(dict.fromkeys(names))
