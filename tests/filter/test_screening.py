"""Which readings are used: numbers in range, of sensors that have not frozen."""

import numpy as np
import pytest

from jawenv.filter.belief.state import belief_dtype, filter_settings_dtype, forget_readings
from jawenv.filter.model.encoders import read_motion
from jawenv.filter.readings.screening import (
    FORCE_RATE,
    LOST_FORCE,
    LOST_MOMENT,
    MOMENT_RATE,
    ROUGH,
    SETTLING,
    STILL,
    is_resolved,
    mark_frozen,
    mark_usable,
    repair_samples,
    rough_change,
)
from jawenv.filter.tick import filter_scratch_dtype
from jawenv.kernels.records import record_zeros
from jawenv.mechanics.building import build_jaw

EVERY = np.ones(12, dtype=np.uint8)
JAW = build_jaw()


class Encoders:
    """Readings one after the other, of a jaw that is believed to stand at ``motion``."""

    def __init__(self, allowed=EVERY):
        self.belief = record_zeros(1, belief_dtype(6, 10))[0]
        forget_readings(self.belief)
        self.settings = record_zeros(1, filter_settings_dtype(6, 10))[0]
        self.settings["used"] = allowed
        self.settings["measurement_variance"] = np.square(np.repeat([1e-4, 2e-3, 1e-3, 0.02], 3))
        self.scratch = record_zeros(1, filter_scratch_dtype(6, 12, 10))[0]

    def mark(self, measured):
        self.scratch["measured"] = measured
        left_out = mark_usable(JAW, self.belief, measured, self.settings, self.scratch)
        np.testing.assert_array_equal(self.belief["sensors"]["last_measured"], measured)
        return left_out, self.scratch["used"].copy()


def after(*measured, allowed=EVERY):
    """What is said of the last of these readings."""
    encoders = Encoders(allowed)
    for each in measured[:-1]:
        encoders.mark(each)
    return encoders.mark(measured[-1])


def readings(rng):
    """Readings of a jaw: places (m), angles, velocities (m/s), rates."""
    return rng.normal(size=12) * np.repeat([0.05, 0.2, 0.05, 1.0], 3)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e150, -101.0])
def test_what_is_no_number_or_out_of_range_is_left_out(rng, bad):
    encoders, measured = Encoders(), readings(rng)
    measured[[2, 9]] = bad
    left_out, used = encoders.mark(measured)
    assert left_out == 2
    np.testing.assert_array_equal(np.flatnonzero(used == 0), [2, 9])
    left_out, used = encoders.mark(readings(rng))
    assert left_out == 0 and used.all(), "and the next is believed"


def test_a_repetition_is_left_out_and_a_last_bit_is_a_change(rng):
    encoders = Encoders()
    for _ in range(20):  # so that it is known that there are no steps
        last = readings(rng)
        assert encoders.mark(last)[0] == 0
    measured = readings(rng)
    measured[4], measured[5] = last[4], np.nextafter(last[5], 1.0)
    left_out, used = encoders.mark(measured)
    assert left_out == 1
    np.testing.assert_array_equal(np.flatnonzero(used == 0), [4])
    left_out, used = encoders.mark(measured)
    assert left_out == 12 and not used.any(), "all sensors have frozen"


def rounded(values, step):
    """Numbers in steps, as a file has them: in mm and degrees, and then in SI units."""
    return np.round(values / step) * step * 1e3 / 1e3


def test_an_encoder_with_steps_repeats_itself_until_the_motion_leaves_it(rng):
    """Steps as large as the noise, of a jaw at rest; then the believed jaw opens, and the encoders do not."""
    encoders, steps = Encoders(), np.repeat([1e-4, 2e-3, 1e-3, 0.02], 3)
    repeated, last, true = 0, np.full(12, np.nan), np.zeros(12)
    read_motion(JAW, np.zeros(10), true)
    for _ in range(200):
        measured = rounded(true + rng.normal(size=12) * steps, steps)
        repeated += (measured == last).sum()
        assert encoders.mark(measured)[0] == 0
        last = measured
    assert repeated > 400
    encoders.belief["motion"][2] = 0.02  # rad of opening
    left_out, used = encoders.mark(measured)
    assert left_out >= 2 and not used[[2, 3]].any() and used[6:].all()
    encoders.belief["motion"][2] = 0.0
    assert not encoders.mark(measured)[1][[2, 3]].any(), "frozen until it changes"
    assert encoders.mark(measured + steps)[0] == 0, "one that changes is believed"


def test_what_is_not_allowed_is_neither_used_nor_missed(rng):
    allowed = np.tile(np.repeat([1, 0], 3), 2).astype(np.uint8)
    measured, last = readings(rng), readings(rng)
    measured[[0, 3]] = np.nan
    left_out, used = after(last, measured, allowed=allowed)
    assert left_out == 1
    np.testing.assert_array_equal(np.flatnonzero(used), [1, 2, 6, 7, 8])


class Cell:
    """A load cell without steps, its samples, and the variance of the wrench not known."""

    def __init__(self, rng):
        self.samples, self.before = rng.normal(size=(3, 6)), rng.uniform(0.01, 0.02, 6)
        self.belief = record_zeros(1, belief_dtype(6, 10))[0]
        forget_readings(self.belief)
        self.held, self.lost_for = self.belief["sensors"]["held_sample"], self.belief["sensors"]["lost_for"]
        self.held[:], self.belief["sensors"]["cell_step"] = rng.normal(size=6), 0.0
        self.usable = np.full((3, 6), np.nan)

    def repair(self, dt=0.01, without_noise=()):
        given, self.variance, frozen = self.samples.copy(), self.before.copy(), np.full(6, 7, dtype=np.uint8)
        settings = record_zeros(1, filter_settings_dtype(6, 10))[0]
        settings["cell_repeats"][list(without_noise)] = 1
        mark_frozen(JAW, self.belief, self.samples, settings, frozen)
        number = repair_samples(self.belief, self.samples, frozen, dt, self.variance, self.usable)
        np.testing.assert_array_equal(self.samples, given)
        return number


def test_good_samples_pass(rng):
    cell = Cell(rng)
    assert cell.repair() == 0
    np.testing.assert_array_equal(cell.usable, cell.samples)
    np.testing.assert_array_equal(cell.variance, cell.before)
    np.testing.assert_array_equal(cell.held, cell.samples[2])


def test_a_component_without_noise_may_repeat_itself(rng):
    """Two of four that stay equal or are missing are without noise: one of these is missing."""
    cell = Cell(rng)
    cell.samples[:, :3] = cell.samples[0, :3]
    cell.samples[1, 3] = np.nan
    assert cell.repair(without_noise=[1, 3]) == 3
    np.testing.assert_array_equal(np.flatnonzero(cell.variance > cell.before), [0, 2, 3])
    np.testing.assert_array_equal(cell.usable[:, 1], cell.samples[:, 1])


def test_a_component_that_fails_is_held_and_doubted(rng):
    """By one missing sample, and by three that are the same."""
    cell = Cell(rng)
    held = cell.held.copy()
    cell.samples[1, 0] = np.nan
    cell.samples[:, 2] = cell.samples[0, 2]
    cell.samples[:, 5] = cell.samples[1, 5]
    assert cell.repair() == 3
    failed, good = [0, 2, 5], [1, 3, 4]
    np.testing.assert_array_equal(cell.usable[:, failed], np.tile(held[failed], (3, 1)))
    np.testing.assert_array_equal(cell.usable[:, good], cell.samples[:, good])
    force, moment = 0.01 * FORCE_RATE, 0.01 * MOMENT_RATE
    np.testing.assert_allclose(cell.variance - cell.before, np.array([force, 0, force, 0, 0, moment]) ** 2, rtol=1e-9)


def single(before, now):
    """The samples of a tick that has a reading at its start and one at its end."""
    return np.stack([before, 0.5 * (before + now), now])


def test_a_tick_that_begins_with_the_last_reading_of_the_one_before_is_no_frozen_one(rng):
    cell, before = Cell(rng), rng.normal(size=6)
    cell.belief["sensors"]["cell_step"] = np.inf
    for _ in range(50):
        now = rng.normal(size=6)
        cell.samples[:] = single(before, now)
        assert cell.repair() == 0
        before = now
    assert (cell.belief["sensors"]["cell_step"] == 0.0).all()
    cell.samples[:] = single(now, now)
    assert cell.repair() == 6, "a reading that is repeated to the bit has none of the noise"


@pytest.mark.parametrize("step", [0.01, 0.05])
def test_a_load_cell_with_steps_freezes_as_a_whole_while_the_jaw_moves(rng, step):
    """Moments that no sensor reads stay 0; the forces repeat themselves by chance, and all of them when they freeze."""
    cell, steps = Cell(rng), np.repeat([step, 0.0], 3)
    cell.belief["sensors"]["cell_step"] = np.inf
    before, number = np.zeros(6), 0
    for _ in range(200):
        now = np.round(rng.normal(size=6) * 0.04 / step) * steps
        number += (now[:3] == before[:3]).sum()
        cell.samples[:] = single(before, now)
        cell.belief["motion"][2] += 1e-3
        assert cell.repair() == 0
        before = now
    assert number > 40
    np.testing.assert_allclose(cell.belief["sensors"]["cell_step"][:3], step / 2, rtol=1e-6)
    cell.samples[:] = single(now, now)
    assert cell.repair() == 0, "nothing has moved since"
    cell.belief["motion"][2] += 1.1 * STILL / np.hypot(JAW["mouthpiece"][0], JAW["mouthpiece"][2])
    assert cell.repair() == 6


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
