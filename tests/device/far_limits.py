"""Limits that nothing reaches."""

import numpy as np

from jawenv.device.comfort import limits_dtype, set_general_limits
from jawenv.device.comfort_settings import Comfort


def far_limits():
    limits = np.zeros(1, dtype=limits_dtype(6))[0]
    for name in limits.dtype.names:
        limits[name] = 10.0
    limits["path"] = limits["rest_opening"] = limits["rest_side"] = limits["rest_condyle_side"] = 0.0
    limits["condyle_middle"] = 0.0
    set_general_limits(Comfort().records()[0], limits)
    return limits
