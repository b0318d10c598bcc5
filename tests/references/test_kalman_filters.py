"""The plain filters over whole records: ours against filterpy's, noise laws, scales, what was not read."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from filterpy_filter import FilterpyExtendedKalman
from recorded import held, recording

from jawenv.references.extended_kalman import ExtendedKalman
from jawenv.references.initial import parameter_noise


@pytest.fixture(scope="module")
def record():
    return recording().records[0]


def assert_same(actual, expected, relative):
    """Equal relative to the standard deviations."""
    sd = expected.sd
    np.testing.assert_array_equal(actual.time, expected.time)
    assert (np.abs(actual.mean - expected.mean) / sd).max() < relative
    assert (np.abs(actual.cov - expected.cov) / (sd[:, :, None] * sd[:, None, :])).max() < relative


@pytest.mark.parametrize("gain_sd", [0.0, 0.05])
@pytest.mark.parametrize("noise", [(0.03, 5.0), (0.01, inf)])
def test_the_compiled_filter_is_filterpys(record, gain_sd, noise):
    record = replace(record, gain_sd=gain_sd)
    ours = ExtendedKalman(parameter_rate=noise[0], parameter_time=noise[1]).estimate(record)
    assert_same(ours, FilterpyExtendedKalman(*noise).estimate(record), 1e-9)
    assert len(ours.time) == 61
    assert np.log(ours.sd[0] / ours.sd[-1]).mean() > 0.5, "the record teaches something"


def test_so_it_is_where_a_jaw_cannot_leave_its_plane(record):
    short = held(replace(record.until(0.5), gain_sd=0.05))
    assert_same(ExtendedKalman().estimate(short), FilterpyExtendedKalman().estimate(short), 1e-9)


def test_readings_that_are_missing_are_skipped(record, rng):
    """At random, and for half a second all of them."""
    measured = np.where(rng.random(record.measured.shape) < 0.3, np.nan, record.measured)
    measured[100:150] = np.nan
    holey = replace(record, measured=measured)
    ours = ExtendedKalman().estimate(holey)
    assert_same(ours, FilterpyExtendedKalman().estimate(holey), 1e-9)
    assert np.log(ours.sd[-1] / ExtendedKalman().estimate(record).sd[-1]).mean() > 0.02


def test_the_gain_error_costs_certainty(record):
    sure, unsure = (ExtendedKalman().estimate(replace(record, gain_sd=sd)) for sd in (0.0, 0.1))
    assert np.log(unsure.sd[-1] / sure.sd[-1]).mean() > 0.01


def test_the_scales_agree_where_the_parameters_are_known_well(record):
    """Prior sd 1e-4: the logarithm is a straight line over it, and the delta method is exact."""
    certain = replace(record, prior=replace(record.prior, mean=record.truth, sd=np.full(12, 1e-4)))
    logs = ExtendedKalman("log", parameter_rate=1e-5).estimate(certain)
    assert_same(ExtendedKalman("linear", parameter_rate=1e-5).estimate(certain), logs, 2e-3)
    other = ExtendedKalman("linear").estimate(record).mean[-1]
    apart = np.abs(other - ExtendedKalman().estimate(record).mean[-1])
    assert apart.max() > 3e-3, "they differ where they may"


def test_a_linear_estimate_below_zero_becomes_a_small_positive_one(record):
    """A wide prior with a wrong mean throws linear parameters beyond 0; the result stays a finite log."""
    wide = replace(record, prior=replace(record.prior, sd=np.full(12, 3.0)))
    estimate = ExtendedKalman("linear").estimate(wide)
    assert np.isfinite(estimate.mean).all()
    assert (estimate.mean >= record.prior.mean + np.log(1e-3) - 1e-12).all()


def test_the_parameters_noise_is_the_integral_of_its_decaying_variance(record):
    noise = parameter_noise(record, 0.03, 5.0)
    ends = np.arange(len(noise) + 1) * record.dt
    expected = -np.diff(0.03**2 * 2.5 * np.exp(-ends / 2.5))
    np.testing.assert_allclose(noise, expected, rtol=1e-9)
    np.testing.assert_allclose(parameter_noise(record, 0.01, inf), 1e-4 * record.dt, rtol=1e-12)
    np.testing.assert_allclose(parameter_noise(record, 0.01, 1e9), 1e-4 * record.dt, rtol=1e-6)


def test_constant_noise_bounds_what_can_be_known(record):
    without, constant = (ExtendedKalman(parameter_rate=rate, parameter_time=inf).estimate(record) for rate in (0, 0.1))
    assert (constant.sd[-1] > without.sd[-1]).all()
    assert (np.diff(without.sd, axis=0) <= 1e-12).all()


def test_every_chooses_the_times_and_not_the_numbers(record):
    short = record.until(0.23)
    each, seventh = ExtendedKalman(every=1).estimate(short), ExtendedKalman(every=7).estimate(short)
    np.testing.assert_array_equal(each.time, short.time)
    np.testing.assert_allclose(seventh.time, [0.0, 0.07, 0.14, 0.21, 0.23], atol=1e-12)
    np.testing.assert_array_equal(seventh.mean, each.mean[[0, 7, 14, 21, 23]])
    np.testing.assert_array_equal(seventh.cov, each.cov[[0, 7, 14, 21, 23]])
