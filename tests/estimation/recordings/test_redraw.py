"""The same motion measured again: new noise of the size that the record claims, the same truth."""

from dataclasses import replace

import newton_euler as twin
import numpy as np
import pytest
from estimation_records import records

from jawenv.errors import InputError
from jawenv.estimation.recordings.redraw import redraw
from jawenv.estimation.thesis_methods.least_squares import NonlinearLeastSquares

CELL_SD = np.repeat([0.07, 0.0014], 3)


def test_noise_is_new_and_of_its_size(rng):
    record = records("Jaw")[0]
    one, other = redraw(record, rng, CELL_SD), redraw(record, rng, CELL_SD)
    clean = np.array([twin.measurement(record.jaw, state) for state in record.states[::10]])
    np.testing.assert_allclose((one.measured[::10] - clean).std(axis=0), record.measurement_sd, rtol=0.2)
    noise = (one.measured - other.measured) / np.sqrt(2.0) / record.measurement_sd
    np.testing.assert_allclose(noise.std(axis=0), 1.0, rtol=0.1)
    # The gain's share is a multiple of the wrench.
    for drawn in (one, other):
        for k in range(6):
            wrench, read = record.wrenches[:, :, k].ravel(), drawn.samples[:, :, k].ravel()
            gain = wrench @ read / (wrench @ wrench)
            assert np.std(read - gain * wrench) == pytest.approx(CELL_SD[k], rel=0.05)
    assert one.states is record.states and one.truth is record.truth


def test_the_same_generator_gives_the_same_and_gains_differ(rng):
    record = records("Jaw")[0]
    one, other = (redraw(record, np.random.default_rng(3), CELL_SD) for _ in range(2))
    np.testing.assert_array_equal(one.samples, other.samples)
    pull = record.wrenches[:, :, :3].ravel()
    gains = [pull @ pull / (pull @ redraw(record, rng, CELL_SD).samples[:, :, :3].ravel()) - 1.0 for _ in range(60)]
    assert np.std(gains) == pytest.approx(record.gain_sd, rel=0.35)


def test_what_was_not_read_is_not_read_again(rng):
    record = records("Jaw")[0]
    point = record.measured.copy()
    point[:, 3:6] = np.nan
    drawn = redraw(replace(record, measured=point), rng, CELL_SD)
    np.testing.assert_array_equal(np.isnan(drawn.measured), np.isnan(point))


def test_estimates_scatter_about_each_other_as_they_claim(rng):
    """Less than claimed: the unmodelled wrench is in the motion and the same in all draws."""
    record = records("JawHinge")[0]
    found = [NonlinearLeastSquares(starts=1).estimate(redraw(record, rng, CELL_SD)) for _ in range(60)]
    spread, claimed = np.std([one.mean[0] for one in found], axis=0), np.mean([one.sd[0] for one in found], axis=0)
    assert (spread < 1.3 * claimed).all() and (spread > 0.05 * claimed).all()


def test_a_record_without_truth_cannot_be_drawn_again(rng):
    record = records("Jaw")[0]
    with pytest.raises(InputError, match="no true states"):
        redraw(replace(record, states=None), rng, CELL_SD)
    with pytest.raises(InputError, match="cell_sd has shape"):
        redraw(record, rng, CELL_SD[:3])
