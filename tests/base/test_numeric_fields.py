"""Settings that are numbers: what a field declares is what is checked, and what the kernels' record gets."""

import pickle
import re
from dataclasses import replace

import numpy as np
import pytest

from jawenv.base.errors import InputError
from jawenv.base.numeric_fields import NumericFields
from jawenv.device.comfort_settings import Comfort
from jawenv.device.device import DEVICE, Device
from jawenv.reality import REALITY, Reality

KINDS = pytest.mark.parametrize("kind", [Device, Reality, Comfort])


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
    assert all(np.any(Device(unmodelled_time_s=0.5).records()[name]) for name in DEVICE.names or ())


@KINDS
def test_units_become_those_of_the_record(kind: type[NumericFields]) -> None:
    fields = kind.numeric_fields()
    given = {name: numeric.high * (0.1 + 0.01 * i) for i, (name, numeric) in enumerate(fields.items())}
    factors = {"mm": 1e-3, "mm/s": 1e-3, "ms": 1e-3, "deg": np.pi / 180.0}
    wanted = [value * factors.get(fields[name].unit, 1.0) for name, value in given.items()]
    np.testing.assert_allclose(list(kind(**given).in_si().values()), wanted, rtol=1e-15)


def test_names_of_the_record_that_are_not_the_fields() -> None:
    record = Reality(cell_bias_N=2.0, cell_bias_N_m=0.1, encoder_play_mm=3.0, encoder_play_deg=9.0).records()[0]
    assert (record["cell_bias_force"], record["cell_bias_moment"], record["play_position"]) == (2.0, 0.1, 0.003)
    assert record["play_angle"] == np.radians(9.0) and Device(thermal_s=8.0).records()["thermal_time"] == 8.0
    device = Device(vertical_arm_mm=20.0, lever=0.5, motor_peak_N=200.0, motor_no_load_mm_s=10.0).records()[0]
    np.testing.assert_array_equal(device["point"][:2], [[0.0, 0.02, 0.0], [0.0, -0.02, 0.0]])
    assert device["thrust_peak"] == 100.0 and device["no_load_speed"] == 0.02


@pytest.mark.parametrize(
    ("kind", "name"), [(kind, name) for kind in (Device, Reality, Comfort) for name in kind.numeric_fields()]
)
def test_faulty_values_are_refused_in_one_line_that_names_them(kind: type[NumericFields], name: str) -> None:
    high, zero = kind.numeric_fields()[name].high, kind.numeric_fields()[name].zero
    allowed = re.escape(f"a finite number, {'0 or more' if zero else 'more than 0'}, at most {high:g}")
    bad = (-0.1, 1e9, np.nextafter(high, np.inf), np.nan, np.inf, True, "1", None, [0.1], *(() if zero else (0.0,)))
    for value in bad:
        with pytest.raises(InputError, match=rf"^{kind.__name__.lower()}\.{name} is .*; allowed: {allowed}$"):
            kind(**{name: value})


@KINDS
def test_values_are_frozen_compared_hashed_and_pickled(kind: type[NumericFields]) -> None:
    name, numeric = next(iter(kind.numeric_fields().items()))
    one, other = kind(**{name: numeric.high}), kind()
    assert one == replace(other, **{name: np.float32(numeric.high)}) != other
    assert hash(one) == hash(pickle.loads(pickle.dumps(one))) and pickle.loads(pickle.dumps(one)) == one
    with pytest.raises(InputError, match=f"^{kind.__name__.lower()}.size is not a field of {kind.__name__}; allowed: "):
        kind.from_dict({"size": 1.0})
