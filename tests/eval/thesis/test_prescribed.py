"""A jaw led along a prescribed motion moves as the equations of motion say."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import beta, chi2

from eval.thesis.prescribed import PrescribedMotion, with_noise
from eval.thesis.settings import DEVICE, SENSORS, lowering_then_sideways, plane_record, sampled_record
from jawenv.base.errors import InputError
from jawenv.filter.bound.joint_recursion import joint_scratch_dtype
from jawenv.filter.bound.joint_step import propagate
from jawenv.recordings.dividing import divided
from jawenv.recordings.thinning import thinned
from jawenv.references.extended_kalman import ExtendedKalman


def test_keyframes_are_met_at_rest():
    motion = PrescribedMotion({"theta": ((0.0, 2.0, 3.0), (0.1, 0.4, 0.2))})
    q, rate = motion.at(np.array([0.0, 2.0, 3.0]))
    np.testing.assert_allclose(q[:, 2], [0.1, 0.4, 0.2])
    np.testing.assert_allclose(rate, 0.0, atol=1e-12)
    before, after = motion.at(np.array([1.0 - 1e-6]))[0], motion.at(np.array([1.0 + 1e-6]))[0]
    np.testing.assert_allclose((after - before) / 2e-6, motion.at(np.array([1.0]))[1], atol=1e-8)


@pytest.mark.parametrize("clean", [plane_record, lowering_then_sideways])
def test_the_wrench_gives_the_motion(clean):
    record = clean()
    muscles = np.exp(record.truth.reshape(-1, 2))[record.jaw["muscle"]]
    scratch = np.zeros(1, dtype=joint_scratch_dtype(len(record.truth) // 2, len(muscles)))[0]
    for k in range(0, len(record.samples), 50):
        state = record.states[k].copy()
        propagate(record.jaw, muscles, state, record.wrenches[k], np.zeros(6), 0.0, record.dt, scratch)
        np.testing.assert_allclose(state, record.states[k + 1], atol=1e-5)


def four_standard_errors(number):
    """Relative, of the sd of so many independent normal numbers."""
    return 4.0 / np.sqrt(2.0 * number)


def test_noise_is_that_of_the_device():
    clean = plane_record()
    noisy = with_noise(clean, SENSORS, np.random.default_rng(0))
    error = (noisy.measured - clean.measured) / clean.measurement_sd
    np.testing.assert_allclose(error.std(axis=0), 1.0, rtol=four_standard_errors(len(error)))
    cell = (noisy.samples - clean.samples)[:, :, 1]  # no force to the side in the plane, so no gain error either
    assert cell.std() == pytest.approx(SENSORS.cell_force_N, rel=four_standard_errors(cell.size))


def test_thinning_keeps_every_nth_reading_and_averages_the_load_cell():
    clean = plane_record()
    for every in (1, 2, 5):
        thin = thinned(clean, every)
        np.testing.assert_array_equal(thin.measured, clean.measured[::every])
        np.testing.assert_allclose(thin.samples[:, [0, 2]], clean.samples[::every, [0]][:, [0, 0]], atol=0.1)
        middle = 0.5 * (thin.time[:-1] + thin.time[1:])
        at = np.interp(middle, 0.5 * (clean.time[:-1] + clean.time[1:]), clean.samples[:, 1, 2])
        np.testing.assert_allclose(thin.samples[:, 1, 2], at, atol=2e-3)
        for sd in ("wrench_sd", "cell_sd"):
            np.testing.assert_allclose(getattr(thin, sd), getattr(clean, sd) / np.sqrt(every))
    short = thinned(replace(clean, states=None, wrenches=None).until(0.1), 3)
    assert len(short.samples) == 3 and short.states is None
    for every in (0, 1.5, True, len(clean.samples) + 1):
        with pytest.raises(InputError):
            thinned(clean, every)
    for parts in (0, 1.5, True):
        with pytest.raises(InputError):
            divided(clean, parts)


def simpson(values):
    """Mean over each tick of what three samples say."""
    return np.einsum("i,ti...->t...", np.array([1.0, 4.0, 1.0]) / 6.0, values)


def test_a_longer_tick_has_the_impulse_of_its_short_ones_and_where_it_lies():
    clean = plane_record()
    rough = replace(clean, samples=clean.samples + np.random.default_rng(0).normal(size=clean.samples.shape))
    thin = thinned(rough, 5)
    ticks = rough.samples.reshape(-1, 5, 3, 6)
    within = (np.arange(5)[:, None] + np.array([0.0, 0.5, 1.0])) / 5.0
    np.testing.assert_allclose(simpson(thin.samples), simpson(rough.samples).reshape(-1, 5, 6).mean(axis=1), atol=1e-12)
    moment = np.mean([simpson(ticks[:, j] * within[j][:, None]) for j in range(5)], axis=0)
    np.testing.assert_allclose(simpson(thin.samples * np.array([0.0, 0.5, 1.0])[:, None]), moment, atol=1e-12)


def test_thinning_leaves_a_parabola_as_it_is_and_a_frozen_load_cell_frozen():
    clean = plane_record()
    time = np.stack([clean.time[:-1], 0.5 * (clean.time[:-1] + clean.time[1:]), clean.time[1:]], axis=1)
    samples = np.repeat((1.0 + 2.0 * time - 3.0 * time**2)[:, :, None], 6, axis=2)
    samples[:, :, 1] = 1.0 / 3.0
    thin = thinned(replace(clean, samples=samples), 5)
    longer = np.stack([thin.time[:-1], 0.5 * (thin.time[:-1] + thin.time[1:]), thin.time[1:]], axis=1)
    np.testing.assert_allclose(thin.samples[:, :, 0], 1.0 + 2.0 * longer - 3.0 * longer**2, rtol=1e-9, atol=1e-9)
    assert (thin.samples[:, :, 1] == 1.0 / 3.0).all()


def test_dividing_ticks_keeps_readings_impulse_and_noise():
    clean = plane_record()
    assert divided(clean, 1) is clean
    fine = divided(thinned(clean, 5), 5)
    np.testing.assert_allclose(fine.time, clean.time, atol=1e-9)
    np.testing.assert_array_equal(fine.measured[::5], clean.measured[::5])
    assert np.isnan(np.delete(fine.measured, np.s_[::5], axis=0)).all()
    np.testing.assert_allclose(fine.wrench_sd, clean.wrench_sd)
    np.testing.assert_allclose(fine.cell_sd, clean.cell_sd)
    mean = simpson(clean.samples).reshape(-1, 5, 6).mean(axis=1)
    np.testing.assert_allclose(simpson(fine.samples).reshape(-1, 5, 6).mean(axis=1), mean, atol=1e-9)
    np.testing.assert_allclose(fine.samples, clean.samples, atol=0.05)


def test_a_filter_with_short_ticks_is_less_sure_on_a_slow_recording():
    clean = sampled_record(0.1)
    nees = {1: [], 10: []}
    for seed in range(3):
        slow = with_noise(clean, DEVICE, np.random.default_rng(seed))
        for parts, found in nees.items():
            belief = ExtendedKalman("log").estimate(divided(slow, parts))
            error = belief.mean[-1] - clean.truth
            found.append(error @ np.linalg.solve(belief.cov[-1], error))
    assert np.median(nees[10]) < chi2.ppf(beta.ppf(0.999, 2, 2), 12), "99.9 % of medians of three"
    assert np.median(nees[1]) > 4.0 * np.median(nees[10])
