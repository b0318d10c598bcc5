"""Which readings are used: numbers in range that have changed."""

import numpy as np
import pytest

from jawenv.filter.readings.screening import (
    FORCE_RATE,
    LOST_FORCE,
    LOST_MOMENT,
    MOMENT_RATE,
    ROUGH,
    SETTLING,
    is_resolved,
    mark_usable,
    repair_samples,
    rough_change,
)
from jawenv.filter.state import belief_dtype
from jawenv.filter.tick import filter_settings_dtype
from jawenv.kernels.records import record_zeros

EVERY = np.ones(12, dtype=np.uint8)


def mark(measured, last, allowed=EVERY):
    used = np.full(12, 7, dtype=np.uint8)
    return mark_usable(measured, last, allowed, used), used


def readings(rng):
    """Of a jaw: places (m), angles, velocities (m/s), rates."""
    return rng.normal(size=12) * np.repeat([0.05, 0.2, 0.05, 1.0], 3)


def test_numbers_that_have_changed_are_used(rng):
    measured, last = readings(rng), readings(rng)
    left_out, used = mark(measured, last)
    assert left_out == 0
    np.testing.assert_array_equal(used, EVERY)
    np.testing.assert_array_equal(last, measured)


def test_the_first_reading_repeats_nothing(rng):
    left_out, used = mark(readings(rng), np.full(12, np.nan))
    assert left_out == 0 and used.all()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e150, -101.0])
def test_what_is_no_number_or_out_of_range_is_left_out(rng, bad):
    measured, last = readings(rng), readings(rng)
    measured[[2, 9]] = bad
    left_out, used = mark(measured, last)
    assert left_out == 2
    np.testing.assert_array_equal(np.flatnonzero(used == 0), [2, 9])
    left_out, used = mark(readings(rng), last)
    assert left_out == 0 and used.all(), "and the next is believed"


def test_a_repetition_is_left_out_and_a_last_bit_is_a_change(rng):
    last = readings(rng)
    measured = readings(rng)
    measured[4], measured[5] = last[4], np.nextafter(last[5], 1.0)
    left_out, used = mark(measured, last)
    assert left_out == 1
    np.testing.assert_array_equal(np.flatnonzero(used == 0), [4])
    left_out, used = mark(measured, last)
    assert left_out == 12 and not used.any(), "all sensors have frozen"


def test_what_is_not_allowed_is_neither_used_nor_missed(rng):
    allowed = np.tile(np.repeat([1, 0], 3), 2).astype(np.uint8)
    measured, last = readings(rng), readings(rng)
    measured[[0, 3]] = np.nan
    left_out, used = mark(measured, last, allowed)
    assert left_out == 1
    np.testing.assert_array_equal(np.flatnonzero(used), [1, 2, 6, 7, 8])


class Cell:
    """A load cell's samples, what the filter carries of the last ones, and the variance of the wrench not known."""

    def __init__(self, rng):
        self.samples, self.before = rng.normal(size=(3, 6)), rng.uniform(0.01, 0.02, 6)
        self.belief = np.zeros(1, dtype=belief_dtype(6, 10))[0]
        self.last, self.held, self.lost_for = (self.belief[name] for name in ("last_sample", "held_sample", "lost_for"))
        self.last[:], self.held[:] = rng.normal(size=6), rng.normal(size=6)
        self.usable = np.full((3, 6), np.nan)

    def repair(self, dt=0.01, without_noise=()):
        given, self.variance = self.samples.copy(), self.before.copy()
        settings = np.zeros(1, dtype=filter_settings_dtype(6, 10))[0]
        settings["dt"], settings["cell_repeats"][list(without_noise)] = dt, 1
        number = repair_samples(self.belief, self.samples, settings, self.variance, self.usable)
        np.testing.assert_array_equal(self.samples, given)
        np.testing.assert_array_equal(self.last, given[2])
        return number


def test_good_samples_pass(rng):
    cell = Cell(rng)
    assert cell.repair() == 0
    np.testing.assert_array_equal(cell.usable, cell.samples)
    np.testing.assert_array_equal(cell.variance, cell.before)
    np.testing.assert_array_equal(cell.held, cell.samples[2])


def test_a_component_without_noise_may_repeat_itself(rng):
    """All of three are the last of the tick before; two are held, and the one that is missing in the fourth."""
    cell = Cell(rng)
    cell.samples[:, :3] = cell.last[:3]
    cell.samples[1, 3] = np.nan
    assert cell.repair(without_noise=[1, 3]) == 3
    np.testing.assert_array_equal(np.flatnonzero(cell.variance > cell.before), [0, 2, 3])
    np.testing.assert_array_equal(cell.usable[:, 1], cell.samples[:, 1])


def test_a_component_that_fails_is_held_and_doubted(rng):
    """By one missing sample, by one that repeats the last tick's, by two that are the same."""
    cell = Cell(rng)
    held = cell.held.copy()
    cell.samples[1, 0] = np.nan
    cell.samples[0, 2] = cell.last[2]
    cell.samples[2, 5] = cell.samples[1, 5]
    assert cell.repair() == 3
    failed, good = [0, 2, 5], [1, 3, 4]
    np.testing.assert_array_equal(cell.usable[:, failed], np.tile(held[failed], (3, 1)))
    np.testing.assert_array_equal(cell.usable[:, good], cell.samples[:, good])
    force, moment = 0.01 * FORCE_RATE, 0.01 * MOMENT_RATE
    np.testing.assert_allclose(cell.variance - cell.before, np.array([force, 0, force, 0, 0, moment]) ** 2, rtol=1e-9)


@pytest.mark.parametrize(("component", "bad"), [(0, 201.0), (2, -1e5), (3, 20.1), (5, 1e300)])
def test_a_sample_beyond_the_cells_range_is_none(rng, component, bad):
    cell = Cell(rng)
    cell.samples[1, component] = bad
    assert cell.repair() == 1
    assert np.abs(cell.usable).max() < 10.0


def test_the_longer_it_is_held_the_more_it_is_doubted(rng):
    """Up to what the motors can do; twice as fast over a tick that is twice as long."""
    cell, slow = Cell(rng), Cell(rng)
    held, added = cell.held.copy(), []
    cell.samples[:] = slow.samples[:] = np.nan
    for _ in range(20):
        assert cell.repair() == 6
        np.testing.assert_array_equal(cell.usable, np.tile(held, (3, 1)))
        added.append(np.sqrt(cell.variance - cell.before))
    assert slow.repair(dt=0.02) == 6
    np.testing.assert_allclose(np.sqrt(slow.variance - slow.before), added[1], rtol=1e-9)
    assert (np.diff(added[:6], axis=0)[:, :3] > 0.0).all()
    np.testing.assert_allclose(added[-1], np.repeat([LOST_FORCE, LOST_MOMENT], 3), rtol=1e-9)


def test_a_frozen_sensor_stays_what_it_was_when_last_believed(rng):
    cell = Cell(rng)
    cell.repair()
    frozen = cell.samples[2].copy()
    for _ in range(3):
        cell.samples[:] = frozen
        assert cell.repair() == 6
        np.testing.assert_array_equal(cell.usable, np.tile(frozen, (3, 1)))
    np.testing.assert_allclose(cell.lost_for, 0.03)


def test_after_a_lost_sample_the_next_is_believed(rng):
    cell = Cell(rng)
    cell.samples[2] = np.nan
    assert cell.repair() == 6
    cell.samples = rng.normal(size=(3, 6))
    assert cell.repair() == 0
    np.testing.assert_array_equal(cell.lost_for, 0.0)


def test_a_tick_that_is_not_resolved_and_a_few_after_it_teach_nothing():
    belief, held = record_zeros(1, belief_dtype(1, 10))[0], np.ones((3, 6))
    rough = rough_change(np.full(6, 0.03), 0.01)
    jump, bend = held.copy(), held.copy()
    jump[2, 1] += 1.1 * ROUGH
    bend[1, 2] += 0.6 * ROUGH
    for samples in (jump, bend):
        assert is_resolved(belief, held, rough)
        assert not is_resolved(belief, samples, rough)
        assert [is_resolved(belief, held, rough) for _ in range(SETTLING + 1)] == SETTLING * [False] + [True]
    smooth = held + 0.9 * ROUGH * np.linspace(0.0, 1.0, 3)[:, None]
    assert is_resolved(belief, smooth, rough)


def test_noise_of_the_samples_is_not_taken_for_a_change(rng):
    for sd, dt in ((0.04, 0.01), (0.5, 0.01), (2.0, 0.05)):
        belief, rough = record_zeros(1, belief_dtype(1, 10))[0], rough_change(np.full(6, sd / 2**0.5), dt)
        assert all(is_resolved(belief, rng.normal(scale=sd, size=(3, 6)), rough) for _ in range(2000))
    assert np.all(rough_change(np.zeros(6), 0.05) == 5.0 * ROUGH)
