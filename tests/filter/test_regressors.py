"""Half-way pose and the wrenches of unit coefficients, against plain NumPy."""

import newton_euler as twin
import numpy as np
import pytest
from running import half_way, line_wrenches

import jawenv
from jawenv.filter.belief.state import tension_columns
from jawenv.filter.model.basis import build_basis
from jawenv.filter.model.regressors import middle_of, set_line_wrenches
from jawenv.ladder import MODELS
from jawenv.mechanics import build_jaw


@pytest.mark.parametrize("model", ["jaw", "hinge"])
def test_the_wrench_of_unit_coefficients(model, rng):
    """One line to a muscle and two; columns beyond the gain error's are zero."""
    muscles = MODELS[model].muscles
    jaw = build_jaw(muscles, free=MODELS[model].free)
    basis = build_basis(jaw, jawenv.cohort("trismus", muscles).prior)[0]
    columns = tension_columns(len(muscles))
    before = np.zeros(10)
    before[[0, 2]] = 4e-3, 0.2
    after = before + 1e-2 * rng.normal(size=10)
    trend, line_wrench = rng.normal(size=6), np.full((6, columns), np.nan)
    pose, place = middle_of(jaw, before, after)
    expected_place, R = half_way(jaw, before, after)
    np.testing.assert_allclose(place, expected_place, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(twin.rotation(np.array(pose)), R, rtol=1e-12, atol=1e-15)
    set_line_wrenches(jaw, basis, trend, pose, place, line_wrench)
    expected = line_wrenches(jaw, basis, expected_place, R, trend)
    np.testing.assert_allclose(line_wrench[:, : expected.shape[1]], expected, rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(line_wrench[:, expected.shape[1] :], 0.0)
    assert columns % 8 == 0 and columns - expected.shape[1] in range(8)
