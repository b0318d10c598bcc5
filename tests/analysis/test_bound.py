"""The bound along a record: the environment's numbers, and the joint problem written out by an independent model."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy_model import measurement_with_derivative, step_with_derivative

import jawenv
from agents import load_agent
from jawenv.analysis.bound import bound_along
from jawenv.base.errors import InputError
from jawenv.filter.readings.cell_trend import TREND_TIME

N, P = 10, 12  # motion and parameters of the reference model
SHORT = 0.2  # s; the independent model takes its time
SWINGS = "opening_with_swings_and_fore_aft"


@cache
def played(env_id, maneuver=SWINGS, episode_s=2.0):
    """Two patients of a rung, with the bound that the environment tracked."""
    agent = load_agent(maneuver, env_id=env_id, control="force")
    settings = {"record": True, "track_bound": True, "episode_s": episode_s}
    return jawenv.play(agent, patients=2, seed=6022, env_kwargs=settings, env_id=env_id)


def a_record():
    return played("jawenv/Jaw-v3").records[0]


# Where a jaw is held still on its teeth, the filter steps otherwise than the bound.
@pytest.mark.parametrize(
    ("env_id", "maneuver"), [("jawenv/Jaw-v3", SWINGS), ("jawenv/Jaw-v3", "hold_still"), ("jawenv/JawHinge-v3", SWINGS)]
)
def test_it_is_what_the_environment_tracks(env_id, maneuver):
    recording = played(env_id, maneuver)
    for i, record in enumerate(recording.records):
        bound = bound_along(record, every=5)
        np.testing.assert_allclose(bound.time, recording.time, atol=1e-9)
        np.testing.assert_allclose(bound.sd, recording.bound_sd[i], rtol=1e-9)
        np.testing.assert_allclose(bound.information, recording.information_bound[i], atol=1e-8)


@cache
def trend_at(tick):
    """Exponential mean of the load cell's readings before a tick, each by Simpson's rule."""
    trend = np.zeros(6)
    for samples in short_record().samples[:tick]:
        trend += (1.0 - np.exp(-short_record().dt / TREND_TIME)) * (np.array([1, 4, 1]) @ samples / 6.0 - trend)
    return trend


@cache
def short_record():
    return a_record().until(SHORT)


@cache
def jacobians():
    """(T, 10, 35) by motion, parameters, gain and the wrench not known, and (T + 1, 12, 10) of the encoders."""
    record, steps = short_record(), []
    for tick in range(len(record.samples)):
        mean = np.concatenate([record.states[tick], record.truth, [0.0]])
        steps.append(step_with_derivative(record.jaw, mean, record.wrenches[tick], trend_at(tick), record.dt)[1])
    rows = [measurement_with_derivative(record.jaw, state)[1] for state in record.states]
    return np.array(steps), np.array(rows)


def parameter_information(record):
    """Schur complement of the parameters in the information matrix of the whole path, load-cell gain known.

    The unknowns are the first motion, the parameters and the unmodelled wrench of every tick, by which all motions are
    given. With the motions themselves as unknowns their process noise would have to be inverted, which is singular.
    """
    steps, rows = jacobians()
    ticks, first = len(steps), N + P
    prior = np.concatenate([record.start_sd, record.prior.sd, np.tile(np.sqrt(record.noise_variance), ticks)])
    information = np.diag(1.0 / prior**2)
    by_all = np.eye(N, len(prior))
    for tick in range(ticks + 1):
        seen = np.isfinite(record.measured[tick])
        row = (rows[tick] @ by_all / record.measurement_sd[:, None])[seen]
        information += row.T @ row
        if tick < ticks:
            by_all = steps[tick][:, :N] @ by_all
            by_all[:, N:first] += steps[tick][:, N:first]
            by_all[:, first + 12 * tick : first + 12 * tick + 12] += steps[tick][:, first + 1 :]
    # In units of the prior's sds, so that the factor is well conditioned.
    information *= np.outer(prior, prior)
    chosen = np.arange(N, first)
    rest = np.delete(np.arange(len(prior)), chosen)
    across = information[np.ix_(chosen, rest)]
    schur = information[np.ix_(chosen, chosen)] - across @ np.linalg.solve(information[np.ix_(rest, rest)], across.T)
    return schur / np.outer(record.prior.sd, record.prior.sd)


def test_it_is_the_joint_problem_written_out_whole():
    record = replace(short_record(), gain_sd=0.0)
    expected = np.linalg.inv(parameter_information(record))
    sd = np.sqrt(np.diag(expected))
    actual = bound_along(record).cov[-1]
    assert np.abs((actual - expected) / np.outer(sd, sd)).max() < 1e-7
    assert (sd < 0.97 * record.prior.sd).any(), "the record does say something"


def test_readings_that_are_missing_are_left_out_of_it():
    """Every second tick without angles: the same as the whole problem without those rows."""
    record = short_record()
    measured = record.measured.copy()
    measured[::2, 3:6] = np.nan
    gappy = replace(record, gain_sd=0.0, measured=measured)
    expected = np.sqrt(np.diag(np.linalg.inv(parameter_information(gappy))))
    np.testing.assert_allclose(bound_along(gappy).sd[-1], expected, rtol=1e-7)
    assert (bound_along(gappy).sd[-1] > bound_along(replace(record, gain_sd=0.0)).sd[-1]).all()


def test_the_gain_error_is_considered_as_schmidt_does():
    """Joseph's form with a gain row of zeros, in dense matrices from the independent model's derivatives."""
    record = replace(short_record(), gain_sd=0.05)
    steps, rows = jacobians()
    size = N + P + 1
    covariance = np.diag(np.concatenate([record.start_sd, record.prior.sd, [record.gain_sd]]) ** 2)
    R, W = np.diag(record.measurement_sd**2), np.diag(record.noise_variance)
    for tick in range(len(rows)):
        if tick > 0:
            F = np.eye(size)
            F[:N] = steps[tick - 1][:, :size]
            G = np.zeros((size, 12))
            G[:N] = steps[tick - 1][:, size:]
            covariance = F @ covariance @ F.T + G @ W @ G.T
        H = np.hstack([rows[tick], np.zeros((12, P + 1))])
        K = covariance @ H.T @ np.linalg.inv(H @ covariance @ H.T + R)
        K[-1] = 0.0
        rest = np.eye(size) - K @ H
        covariance = rest @ covariance @ rest.T + K @ R @ K.T
    sd = np.sqrt(np.diag(covariance))[N : N + P]
    actual = bound_along(record).cov[-1]
    assert np.abs((actual - covariance[N : N + P, N : N + P]) / np.outer(sd, sd)).max() < 1e-7
    assert (bound_along(replace(record, gain_sd=0.0)).sd[-1] < sd - 1e-9).any(), "not knowing the gain costs something"


def test_without_a_reading_it_is_the_prior():
    record = a_record()
    blind = replace(record, measured=np.full_like(record.measured, np.nan))
    np.testing.assert_allclose(bound_along(blind).cov[-1], np.diag(record.prior.sd**2), rtol=1e-12)


def test_the_last_tick_is_always_kept():
    record = a_record()
    np.testing.assert_allclose(bound_along(record, every=150).time, [0.0, 1.5, 2.0])
    np.testing.assert_array_equal(bound_along(record, every=1000).cov[-1], bound_along(record).cov[-1])


def test_a_record_of_a_device_takes_parameters_and_a_motion_from_elsewhere():
    record = a_record()
    mine = replace(record, truth=None, wrenches=None)
    with pytest.raises(InputError):
        bound_along(mine)
    of_samples = bound_along(mine, record.truth).sd[-1]
    np.testing.assert_allclose(of_samples, bound_along(record).sd[-1], rtol=0.05)
    stiffer = bound_along(record, record.truth + 0.5).sd[-1]
    assert np.abs(stiffer / bound_along(record).sd[-1] - 1.0).max() > 0.05


@pytest.mark.parametrize(
    ("change", "arguments"),
    [
        ({"states": None}, {}),
        ({}, {"every": 0}),
        ({}, {"every": 2.5}),
        ({}, {"parameters": np.zeros(3)}),
        ({}, {"parameters": np.full(12, np.nan)}),
        ({"states": np.full((201, 10), np.nan)}, {}),
    ],
)
def test_what_has_no_bound_is_named(change, arguments):
    with pytest.raises(InputError) as caught:
        bound_along(replace(a_record(), **change), **arguments)
    assert "\n" not in str(caught.value)
