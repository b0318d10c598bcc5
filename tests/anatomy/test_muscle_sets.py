"""Sets of whole muscles and of portions."""

import pickle
from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from jawenv.anatomy import (
    MUSCLE_NAMES,
    PARAMETER_NAMES,
    PORTIONS,
    WHOLE_MUSCLES,
    attachment,
    muscle_set,
    parameter_names,
)


def test_names_and_their_order() -> None:
    assert MUSCLE_NAMES == (
        "masseter_left",
        "temporalis_left",
        "medial_pterygoid_left",
        "masseter_right",
        "temporalis_right",
        "medial_pterygoid_right",
    )
    assert PARAMETER_NAMES[:3] == ("log_F_o/masseter_left", "log_b/masseter_left", "log_F_o/temporalis_left")
    assert PARAMETER_NAMES[-1] == "log_b/medial_pterygoid_right"
    assert len(PARAMETER_NAMES) == 12
    assert parameter_names(["a"]) == ("log_F_o/a", "log_b/a")
    assert muscle_set().names == MUSCLE_NAMES


def test_whole_masseter_is_the_force_weighted_mean() -> None:
    # Worked by hand: (190.4 superficial + 81.6 deep) / 272, mm.
    muscles = muscle_set()
    right = muscles.names.index("masseter_right")
    origin = (0.7 * np.array([37.9, -52.3, -9.1])) + 0.3 * np.array([30.7, -54.0, -6.0])
    insertion = (0.7 * np.array([6.2, -44.9, -40.7])) + 0.3 * np.array([8.0, -45.0, -30.0])
    np.testing.assert_allclose(1e3 * muscles.origin_m[right], origin, atol=1e-9)
    np.testing.assert_allclose(1e3 * muscles.insertion_m[right], insertion, atol=1e-9)
    assert 1e3 * muscles.l_o_m[right] == pytest.approx(41.985, abs=1e-3)


def test_portions_keep_the_lines_of_the_table() -> None:
    portions = muscle_set(PORTIONS)
    assert len(portions) == 12
    for i, name in enumerate(portions.names):
        portion, side = name.rsplit("_", 1)
        line = attachment(portion, side)
        np.testing.assert_allclose(portions.origin_m[i], line.origin_m, rtol=1e-15)
        np.testing.assert_allclose(portions.insertion_m[i], line.insertion_m, rtol=1e-15)


@pytest.mark.parametrize("groups", [WHOLE_MUSCLES, PORTIONS])
def test_the_left_half_mirrors_the_right(groups: dict[str, tuple[str, ...]]) -> None:
    muscles = muscle_set(groups)
    n = len(groups)
    np.testing.assert_array_equal(muscles.origin_m[:n], muscles.origin_m[n:] * [1, -1, 1])
    np.testing.assert_array_equal(muscles.insertion_m[:n], muscles.insertion_m[n:] * [1, -1, 1])
    np.testing.assert_array_equal(muscles.l_o_m[:n], muscles.l_o_m[n:])


def test_rest_length_is_the_closed_jaw_length_and_the_muscles_close() -> None:
    muscles = muscle_set()
    line = muscles.origin_m - muscles.insertion_m
    np.testing.assert_allclose(muscles.l_o_m, np.sqrt((line**2).sum(axis=1)), rtol=1e-15)
    # Opening is positive about y, so a closing pull has a negative moment about the condyles' axis.
    assert np.all(np.cross(muscles.insertion_m, line)[:, 1] < 0)


def test_arrays_cannot_be_changed_also_after_pickling() -> None:
    for muscles in (muscle_set(), pickle.loads(pickle.dumps(muscle_set()))):
        with pytest.raises(ValueError, match="read-only"):
            muscles.origin_m[0, 0] = 1.0
        with pytest.raises(FrozenInstanceError):
            muscles.origin_m = np.zeros((6, 3))
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(muscle_set())).l_o_m, muscle_set().l_o_m)
