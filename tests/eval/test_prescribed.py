"""A jaw led along a prescribed motion moves as the equations of motion say."""

from dataclasses import replace

import numpy as np
import pytest

from eval.thesis.prescribed import Motion, with_noise
from eval.thesis.settings import SENSORS, lowering_then_sideways, plane_record
from jawenv.errors import InputError
from jawenv.estimation.ekf import filter_scratch_dtype
from jawenv.estimation.sensitivity import propagate
from jawenv.estimation.thinning import thinned


def test_keyframes_are_met_at_rest():
    motion = Motion({"theta": ((0.0, 2.0, 3.0), (0.1, 0.4, 0.2))})
    q, rate = motion.at(np.array([0.0, 2.0, 3.0]))
    np.testing.assert_allclose(q[:, 2], [0.1, 0.4, 0.2])
    np.testing.assert_allclose(rate, 0.0, atol=1e-12)
    before, after = motion.at(np.array([1.0 - 1e-6]))[0], motion.at(np.array([1.0 + 1e-6]))[0]
    np.testing.assert_allclose((after - before) / 2e-6, motion.at(np.array([1.0]))[1], atol=1e-8)


@pytest.mark.parametrize("clean", [plane_record, lowering_then_sideways])
def test_the_wrench_gives_the_motion(clean):
    record = clean()
    muscles = np.exp(record.truth.reshape(-1, 2))[record.jaw["muscle"]]
    scratch = np.zeros(1, dtype=filter_scratch_dtype(len(record.truth) // 2, len(muscles)))[0]
    for k in range(0, len(record.samples), 50):
        state = record.states[k].copy()
        propagate(record.jaw, muscles, state, record.wrenches[k], np.zeros(6), 0.0, record.dt, scratch)
        np.testing.assert_allclose(state, record.states[k + 1], atol=1e-5)


def test_noise_is_that_of_the_device():
    clean = plane_record()
    noisy = with_noise(clean, SENSORS, np.random.default_rng(0))
    error = (noisy.measured - clean.measured) / clean.measurement_sd
    np.testing.assert_allclose(error.std(axis=0), 1.0, rtol=0.1)
    cell = (noisy.samples - clean.samples)[:, :, 1]  # no force to the side in the plane, so no gain error either
    assert cell.std() == pytest.approx(SENSORS.cell_force_N, rel=0.05)


def test_thinning_keeps_every_nth_reading():
    clean = plane_record()
    for every in (1, 2, 5):
        thin = thinned(clean, every)
        np.testing.assert_array_equal(thin.measured, clean.measured[::every])
        np.testing.assert_allclose(thin.samples[:, 0], clean.samples[::every, 0])
        np.testing.assert_allclose(thin.samples[:-1, 2], thin.samples[1:, 0], atol=1e-9)
        middle = 0.5 * (thin.time[:-1] + thin.time[1:])
        at = np.interp(middle, 0.5 * (clean.time[:-1] + clean.time[1:]), clean.samples[:, 1, 2])
        np.testing.assert_allclose(thin.samples[:, 1, 2], at, atol=2e-3)
        np.testing.assert_array_equal(thin.cell_sd, clean.cell_sd)
        # Three samples of the load cell are as many in a long tick as in a short one.
        unmodelled = np.sqrt(clean.wrench_sd**2 - clean.cell_sd**2)
        np.testing.assert_allclose(thin.wrench_sd, np.hypot(unmodelled / np.sqrt(every), clean.cell_sd))
    short = thinned(replace(clean, states=None, wrenches=None).until(0.1), 3)
    assert len(short.samples) == 3 and short.states is None
    for every in (0, 1.5, True, len(clean.samples) + 1):
        with pytest.raises(InputError, match="every"):
            thinned(clean, every)
