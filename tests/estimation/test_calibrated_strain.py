"""Strains that regressors are made of: by the regression that they are for, and by what the filter learns."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jawenv.estimation.calibrated_strain import LARGEST_OFFSET, MEAN_OVER, calibrate
from jawenv.estimation.tension_belief import belief_dtype

DT = 0.01


def made():
    belief = np.zeros(1, dtype=belief_dtype(6, 6, 10, 5))[0]
    belief["strain_mean"] = np.nan
    return belief


def calibrated(strains, shared):
    """Strain and share in each of the ticks."""
    belief = made()
    return np.array([calibrate(float(strain), shared, 2, belief, DT) for strain in strains]).T


@pytest.mark.parametrize("noise", [0.5, 1.0])
def test_the_true_strain_has_slope_one_over_the_calibrated_one(noise, rng):
    """Four minutes of a trembling jaw, estimated with an error of its own; over the estimate the slope is diluted."""
    true = 1e-3 * rng.normal(size=24_000)
    error = noise * 1e-3 * rng.normal(size=true.size)
    found, share = calibrated(0.05 + true + error, (noise * 1e-3) ** 2)
    later = slice(500, None)
    slope = np.polyfit(found[later], true[later], 1)[0]
    assert slope == pytest.approx(1.0, abs=0.1)
    diluted = np.polyfit((true + error)[later], true[later], 1)[0]
    assert diluted == pytest.approx(1.0 / (1.0 + noise**2), abs=0.03)
    assert share[later].mean() == pytest.approx(diluted, abs=0.05)


@settings(deadline=None)  # the first call compiles
@given(speed=st.floats(0.05, 5.0), sd=st.floats(1e-6, 1e-4))
def test_a_line_that_is_moved_has_its_own_strain(speed, sd):
    """A strain of 5 % and more per second, after a second of rest; within three ticks but for an error's own size."""
    strains = np.concatenate([np.zeros(100), speed * DT * np.arange(1, 101)])
    found, share = calibrated(strains, sd**2)
    assert share[99] == 0.0
    moved = strains > 10 * LARGEST_OFFSET * sd
    assert (np.abs(found - strains)[moved] < 0.02 * strains[moved]).all()


def test_mean_and_variance_are_of_the_last_second():
    belief = made()
    calibrate(0.1, 1.0, 2, belief, DT)
    assert belief["strain_mean"][2] == 0.1
    assert belief["strain_variance"][2] == 0.0
    assert np.isnan(np.delete(belief["strain_mean"], 2)).all()
    for _ in range(round(MEAN_OVER / DT)):
        strain, share = calibrate(0.2, 1.0, 2, belief, DT)
    assert belief["strain_mean"][2] == pytest.approx(0.2 - 0.1 * np.exp(-1.0), abs=1e-3)
    assert (strain, share) == (belief["strain_mean"][2], 0.0)


@pytest.mark.parametrize("shared", [0.0, -1e-6])
def test_an_estimate_that_shares_nothing_with_its_error_stays(shared):
    found, share = calibrated([0.1, 0.11, 0.09], shared)
    np.testing.assert_allclose(found, [0.1, 0.11, 0.09], rtol=1e-12)
    np.testing.assert_array_equal(share, 1.0)
