"""The likelihood against a dense filter of an independent model, and the information against draws of the likelihood.

Scenes are soft jaws that move between the teeth and the ends of the slide, where no tick is divided and the likelihood
is smooth in the parameters.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy_model import measurement_with_derivative, step_with_derivative, trends
from scipy.stats import chi2, multivariate_normal

import jawenv
from jawenv.ladder import model_named

SOFT = np.log([0.5, 7.0] * 6)
GENTLE = {"full_scale_N": 6.0, "slew_N_s": 12.0, "brake_N_s_m": 30.0}
NO_TONE = {"mandible": {"closing_tone_N": 0.0}}  # soft jaws hang off their teeth


def swings(seconds):
    """Motors that hold the jaw open and swing, each in a sine of its own; 20 Hz."""
    time = np.arange(1, 20 * seconds + 1)[:, None] / 20
    swings, frequencies = np.array([0.15, 0.15, 0.1, 0.1]), np.array([0.9, 0.6, 1.1, 0.7])
    return 0.1 * np.minimum(1.0, time) + swings * np.sin(2.0 * np.pi * frequencies * time)


def push(seconds):
    """Vertical motors that open and close a hinge."""
    time = np.arange(1, 20 * seconds + 1) / 20
    return np.outer(0.4 * np.sin(np.pi * time / seconds) ** 2, [1, 1, 0, 0])


@cache
def drawn(model, draws, cell_gain):
    """One patient and its records with many draws of the noise."""
    theta, actions = (SOFT, swings(3)) if model == "jaw" else (np.log([3.0, 7.0]), push(2))
    kwargs = {"control": "force", "device": GENTLE | {"cell_gain": cell_gain}, "anatomy": NO_TONE}
    env_id = model_named(model).env_id
    return theta, jawenv.simulate([theta] * draws, actions, 100, states=True, env_id=env_id, env_kwargs=kwargs).records


def dense_log_likelihood(record, theta):
    """All readings of a time at once, dense matrices, the independent model; the gain error is estimated."""
    first, size = len(record.start_mean), len(record.start_mean) + len(theta) + 1
    mean = np.concatenate([record.start_mean, theta, [0.0]])
    P = np.diag(np.concatenate([record.start_sd, np.zeros(len(theta)), [record.gain_sd]]) ** 2)
    R, total = np.diag(record.measurement_sd**2), 0.0
    for k, measured in enumerate(record.measured):
        if k > 0:
            samples, trend = record.samples[k - 1], trends(record)[k - 1]
            moved, by_all = step_with_derivative(record.jaw, mean, samples, trend, record.dt)
            F, G = np.eye(size), by_all[:, size:]
            F[:first] = by_all[:, :size]
            W = record.noise_variance.copy()
            W[:6] += P[-1, -1] * ((samples[0] + 4 * samples[1] + samples[2]) / 6 - trend) ** 2
            mean[:first], P = moved, F @ P @ F.T
            P[:first, :first] += G * W @ G.T
        read = np.isfinite(measured)
        if not read.any():
            continue
        expected, by_state = measurement_with_derivative(record.jaw, mean[:first])
        H = np.zeros((12, size))
        H[:, :first] = by_state
        H = H[read]
        S = H @ P @ H.T + R[np.ix_(read, read)]
        total += multivariate_normal(expected[read], S).logpdf(measured[read])
        K = P @ H.T @ np.linalg.inv(S)
        mean, P = mean + K @ (measured[read] - expected[read]), P - K @ H @ P
    return total


def test_it_is_the_density_of_a_dense_filter():
    theta, records = drawn("jaw", 2, 0.01)
    record = records[0].until(0.4)
    measured = record.measured.copy()
    measured[5:9, 3], measured[20] = np.nan, np.nan
    for holed in (record, replace(record, measured=measured)):
        for values in (theta, theta + 0.1):
            assert float(jawenv.log_likelihood(holed, values)) == pytest.approx(
                dense_log_likelihood(holed, values), abs=1e-6
            )


def directional(model, draws, cell_gain, chosen=slice(None)):
    """(draws, d) scores and minus second derivatives in directions in which the mean information is 1.

    The eigenvectors of the information, in rising order, then as many drawn at random; ``chosen`` of these.
    """
    theta, records = drawn(model, draws, cell_gain)
    information = np.mean([jawenv.fisher_information(record) for record in records], axis=0)
    values, vectors = np.linalg.eigh(information)
    random = np.random.default_rng(0).normal(size=(len(theta), len(theta)))
    turned = np.hstack([np.eye(len(theta)), random / np.linalg.norm(random, axis=0)])
    step = 0.1
    moves = step * (vectors / np.sqrt(values) @ turned[:, chosen]).T
    scores, curvatures = [], []
    for record in records:
        middle, *around = jawenv.log_likelihood(record, [theta, *(theta + moves), *(theta - moves)])
        up, down = np.array(around).reshape(2, -1)
        scores.append((up - down) / (2 * step))
        curvatures.append(-(up + down - 2 * middle) / step**2)
    return np.array(scores), np.array(curvatures)


@pytest.mark.parametrize(("model", "draws"), [("hinge", 150), ("jaw", 50)])
def test_the_information_is_the_mean_curvature_and_the_score_has_mean_zero(model, draws):
    scores, curvatures = directional(model, draws, 0.0)
    error = curvatures.std(axis=0, ddof=1) / np.sqrt(draws)
    assert (np.abs(curvatures.mean(axis=0) - 1.0) < 4.0 * error).all()
    assert np.median(error) < 0.05 and error.min() < (0.002 if model == "jaw" else 0.02)
    assert (np.abs(scores.mean(axis=0)) < 4.0 / np.sqrt(draws)).all()
    # The scores' covariance is the information, too: 1 in every direction.
    low, high = chi2.ppf([1e-5, 1.0 - 1e-5], draws - 1) / (draws - 1)
    assert (low < scores.var(axis=0, ddof=1)).all() and (scores.var(axis=0, ddof=1) < high).all()


def test_a_considered_gain_takes_a_little_of_the_information():
    _, curvatures = directional("jaw", 50, 0.01, slice(6, 12))
    assert 1.005 < curvatures.mean(axis=0).max() < 1.04


def test_information_adds_up_over_the_record():
    theta, records = drawn("jaw", 50, 0.0)
    short, whole = (jawenv.fisher_information(record) for record in (records[0].until(1.0), records[0]))
    assert np.linalg.eigvalsh(short).min() > -1e-6
    assert np.linalg.eigvalsh(whole - short).min() > -1e-6
    np.testing.assert_array_equal(whole, whole.T)
    np.testing.assert_allclose(jawenv.fisher_information(records[0], theta), whole, rtol=1e-9)


def test_shapes_and_parameters_out_of_reach():
    theta, records = drawn("jaw", 2, 0.01)
    record = records[0].until(0.2)
    both = jawenv.log_likelihood(record, [theta, theta + 0.1])
    assert both.shape == (2,) and both[0] == jawenv.log_likelihood(record, theta)
    assert jawenv.log_likelihood(record, theta).shape == ()
    assert jawenv.log_likelihood(record, theta + 600.0) == -np.inf
    without = replace(record, truth=None, states=None, wrenches=None)
    assert jawenv.log_likelihood(without, theta) == both[0]


@pytest.mark.parametrize("theta", [np.zeros(11), np.zeros((2, 13)), np.full(12, np.nan), "text", None, 1.0])
def test_what_is_refused(theta):
    record = drawn("jaw", 2, 0.01)[1][0]
    with pytest.raises(jawenv.InputError):
        jawenv.log_likelihood(record, theta)
    with pytest.raises(jawenv.InputError):
        jawenv.fisher_information(replace(record, states=None))
