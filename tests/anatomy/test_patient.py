"""Patients: round trips, and one line for everything that is wrong with one."""

import json
import pickle
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jawenv.anatomy import MUSCLE_NAMES, PARAMETER_NAMES, Patient
from jawenv.base.errors import InputError

MUSCLES = ", ".join(MUSCLE_NAMES)
F_O = dict.fromkeys(MUSCLE_NAMES, 1.2)
B = dict.fromkeys(MUSCLE_NAMES, 7.0)


def per_muscle(high: float) -> st.SearchStrategy[dict[str, float]]:
    number = st.floats(0, high, exclude_min=True)
    return st.fixed_dictionaries(dict.fromkeys(MUSCLE_NAMES, number))


patients = st.builds(
    Patient,
    name=st.text(st.characters(codec="utf-8", categories=("L", "N", "P")), min_size=1, max_size=20),
    F_o_N=per_muscle(200),
    b=per_muscle(60),
    head_tilt_deg=st.floats(-90, 90),
    anatomy_seed=st.none() | st.integers(0, 2**32 - 1) | st.integers(0, 2**32 - 1).map(np.uint64),
)


@settings(deadline=None, max_examples=50)
@given(patients)
def test_json_round_trip_is_exact(patient: Patient) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "patient.json"
        patient.save(path)
        assert Patient.load(path) == patient
        assert [entry.name for entry in Path(folder).iterdir()] == ["patient.json"]
    assert Patient.from_dict(patient.model_dump()) == patient
    assert pickle.loads(pickle.dumps(patient)) == patient


def test_log_parameters_follow_the_parameter_names() -> None:
    patient = Patient(
        F_o_N={name: 1.0 + k for k, name in enumerate(MUSCLE_NAMES)},
        b={name: 10.0 + k for k, name in enumerate(MUSCLE_NAMES)},
    )
    for name, value in zip(PARAMETER_NAMES, patient.log_parameters(), strict=True):
        symbol, muscle = name.split("/")
        assert np.exp(value) == pytest.approx({"log_F_o": patient.F_o_N, "log_b": patient.b}[symbol][muscle])


def test_muscles_may_come_in_any_order_and_any_kind_of_number() -> None:
    patient = Patient(F_o_N=dict(reversed(F_O.items())), b=dict.fromkeys(MUSCLE_NAMES, np.float32(7)))
    assert patient == Patient(F_o_N=F_O, b=B)
    assert tuple(patient.F_o_N) == MUSCLE_NAMES
    assert type(patient.b["masseter_left"]) is float


def without(values: dict[str, float], name: str) -> dict[str, float]:
    return {key: value for key, value in values.items() if key != name}


FAULTS = [
    ({"F_o_N": F_O | {"masseter_left": -1}, "b": B}, "F_o_N.masseter_left is -1; allowed: greater than 0"),
    ({"F_o_N": F_O, "b": B | {"temporalis_right": 61}}, "b.temporalis_right is 61; allowed: less than or equal to 60"),
    ({"F_o_N": F_O | {"digastric": 1.0}, "b": B}, f"F_o_N: unknown muscle 'digastric'; allowed: {MUSCLES}"),
    ({"F_o_N": F_O, "b": without(B, "masseter_right")}, f"b: muscle 'masseter_right' is missing; needed: {MUSCLES}"),
    ({"F_o_N": F_O}, "b is missing"),
    ({}, "F_o_N is missing (and 1 more)"),
    ({"F_o_N": 3, "b": B}, "F_o_N is 3; allowed: a mapping"),
    (
        {"F_o_N": F_O, "b": B, "head_tilt": 3},
        "unknown key 'head_tilt'; allowed: name, F_o_N, b, head_tilt_deg, anatomy_seed",
    ),
    ({"F_0_N": F_O, "b": B}, "unknown key 'F_0_N'; allowed: name, F_o_N, b, head_tilt_deg, anatomy_seed (and 1 more)"),
    ({"F_o_N": F_O, "b": B, "head_tilt_deg": 91}, "head_tilt_deg is 91; allowed: less than or equal to 90"),
    ({"F_o_N": F_O, "b": B, "name": ""}, "name is ''; allowed: at least 1 character"),
]


@pytest.mark.parametrize(("data", "message"), FAULTS)
def test_every_way_in_gives_the_same_line(tmp_path: Path, data: dict[str, object], message: str) -> None:
    with pytest.raises(InputError) as caught:
        Patient(**data)
    assert str(caught.value) == f"Patient: {message}"
    with pytest.raises(InputError) as caught:
        Patient.from_dict(data)
    assert str(caught.value) == f"Patient: {message}"
    path = tmp_path / "patient.json"
    path.write_text(json.dumps(data))
    with pytest.raises(InputError) as caught:
        Patient.load(path)
    assert str(caught.value) == f"{path}: {message}"


def test_patients_are_frozen() -> None:
    patient = Patient(F_o_N=F_O, b=B)
    with pytest.raises(ValueError, match="frozen"):
        patient.name = "other"  # type: ignore[misc]
