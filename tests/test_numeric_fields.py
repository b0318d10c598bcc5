"""Settings that are numbers: what a field declares is what is checked, and what the kernels' record gets."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from jawenv.device.device import DEVICE, Device
from jawenv.errors import InputError
from jawenv.numeric_fields import NumericFields
from jawenv.reality import REALITY, Reality

KINDS = pytest.mark.parametrize("kind", [Device, Reality])


@KINDS
def test_a_name_ends_with_the_unit(kind: type[NumericFields]) -> None:
    for name, numeric in kind.numeric_fields().items():
        assert numeric.unit == "1" or name.endswith("_" + numeric.unit.replace(" ", "_").replace("/", "_"))


def test_all_of_a_record_is_filled() -> None:
    for values, kind in ((Device(cell_gain=0.1), DEVICE), (Reality(), REALITY)):
        filled, records = set(values.in_si()), values.records()
        assert records.dtype == kind and set(kind.names or ()) - filled <= {
            *("point", "direction", "thrust_continuous", "thrust_peak", "no_load_speed"),
            *("lost_below", "frozen_above"),
        }
    assert all(np.any(Device().records()[name]) for name in DEVICE.names or ())


def test_units_become_those_of_the_record() -> None:
    device = Device(
        vertical_arm_mm=20.0, lever=0.5, motor_peak_N=200.0, motor_no_load_mm_s=10.0, encoder_angle_deg=90.0
    )
    record = device.records()[0]
    np.testing.assert_array_equal(record["point"][:2], [[0.0, 0.02, 0.0], [0.0, -0.02, 0.0]])
    assert record["thrust_peak"] == 100.0 and record["no_load_speed"] == 0.02 and record["thermal_time"] == 10.0
    assert record["encoder_angle"] == np.radians(90.0) and record["max_rate"] == 0.04


@KINDS
def test_values_are_frozen_compared_hashed_and_pickled(kind: type[NumericFields]) -> None:
    name, numeric = next(iter(kind.numeric_fields().items()))
    one, other = kind(**{name: numeric.high}), kind()
    assert one == replace(other, **{name: np.float32(numeric.high)}) != other
    assert hash(one) == hash(pickle.loads(pickle.dumps(one))) and pickle.loads(pickle.dumps(one)) == one
    with pytest.raises(InputError, match=f"^{kind.__name__.lower()}.size is not a field of {kind.__name__}; allowed: "):
        kind.from_dict({"size": 1.0})
