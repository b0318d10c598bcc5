"""The alarm: block sums of whitened innovations, where they are judged, and where they begin anew."""

import numpy as np
import pytest
from recorded import recording
from running import Running
from scipy.stats import chi2

from jawenv.filter.alarm.misfit import ALARM, BLOCK, FEWEST, MARGIN, MOST, add_to_block, move_block
from jawenv.filter.belief.state import begin_block


@pytest.fixture
def running():
    """A filter with nothing left to learn, so that a block's statistic is chi-squared."""
    running = Running(recording().records[0])
    running.belief["cov"][:] = 0.0
    running.belief["nuisance_factor"][:] = 0.0
    begin_block(running.belief["block"])
    running.belief["block"]["largest"] = 0.0
    return running


def feed(running, innovations):
    """The largest statistic of blocks of such whitened innovations."""
    update = running.scratch["update"]
    update["by_tension_rows"][:] = 0.0
    for innovation in innovations:
        update["whitened_innovation"][:] = innovation
        add_to_block(running.record.jaw, running.belief, update)
    return ALARM * float(running.belief["block"]["largest"])


def test_a_block_of_white_innovations_is_chi_squared(running, rng):
    statistics = []
    for _ in range(400):
        running.belief["block"]["largest"] = 0.0
        statistics.append(feed(running, rng.normal(size=(BLOCK, 12))))
    assert np.mean(statistics) == pytest.approx(12.0, abs=4 * np.sqrt(24.0 / 400))
    assert np.mean(np.array(statistics) < chi2(12).median()) == pytest.approx(0.5, abs=0.1)


def test_it_is_the_sum_that_counts_and_the_largest_that_stays(running):
    constant = np.zeros((BLOCK, 12))
    constant[:, 3] = 1.0
    assert feed(running, constant) == pytest.approx(BLOCK)
    assert feed(running, np.zeros((BLOCK, 12))) == pytest.approx(BLOCK)
    alternating = constant * np.tile([1.0, -1.0], BLOCK // 2)[:, None]
    running.belief["block"]["largest"] = 0.0
    assert feed(running, alternating) == pytest.approx(0.0)


def test_one_block_may_be_of_a_stop_and_two_ring(running):
    constant = np.full((BLOCK, 12), 1.0)
    feed(running, constant)
    assert running.belief["block"]["largest"] > 1.0 and running.belief["misfit"] == 0.0
    feed(running, 2.0 * constant)
    assert running.belief["misfit"] == pytest.approx(12 * BLOCK / ALARM)


@pytest.mark.parametrize("rate", [0.0, 1.0], ids=["slow", "fast"])
def test_a_little_in_each_second_rings_where_the_jaw_is_slow(running, rate):
    running.belief["motion"][5:] = rate
    running.belief["block"]["slow"], running.belief["block"]["total"], running.belief["misfit"] = 0, 0.0, 0.0
    row = np.full((BLOCK, 12), np.sqrt(16.0 / 12 / BLOCK))
    for blocks in range(1, FEWEST + 1):
        assert running.belief["misfit"] == pytest.approx(16.0 / ALARM if blocks > 2 else 0.0)
        feed(running, row if blocks > 1 else 10.0 * row)
    mean = (MOST + (FEWEST - 1) * 16.0) / FEWEST
    expected = mean / (12 + MARGIN * np.sqrt(24.0 / FEWEST)) if rate == 0.0 else 16.0 / ALARM
    assert running.belief["misfit"] == pytest.approx(expected)
    assert (running.belief["misfit"] > 1.0) == (rate == 0.0)


def test_half_a_block_is_not_judged(running):
    assert feed(running, np.full((BLOCK - 1, 12), 5.0)) == 0.0


def test_the_sum_is_kept_at_the_present_mean(running, rng):
    """Innovations of coefficients that are off by ``steps`` vanish when the mean moves there."""
    block, update = running.belief["block"], running.scratch["update"]
    steps = rng.normal(size=update["by_tension_rows"].shape[1])
    for _ in range(BLOCK - 1):
        update["by_tension_rows"][:] = rng.normal(size=update["by_tension_rows"].shape)
        update["whitened_innovation"][:] = update["by_tension_rows"] @ steps
        add_to_block(running.record.jaw, running.belief, update)
    assert np.abs(block["innovation"]).max() > 1.0
    move_block(block, steps)
    np.testing.assert_allclose(block["innovation"], 0.0, atol=1e-9)


def test_what_is_not_known_of_the_muscles_is_no_misfit(running):
    """The same innovations ring where the parameters are known, and not where these explain them."""
    known, unknown = (Running(recording().records[0]) for _ in range(2))
    known.belief["cov"][:] *= 1e-6
    for each in (known, unknown):
        rows = each.scratch["update"]["by_tension_rows"]
        for _ in range(BLOCK):
            rows[:] = 0.0
            rows[5, :30] = 1.0
            each.scratch["update"]["whitened_innovation"][:] = 0.0
            each.scratch["update"]["whitened_innovation"][5] = 1.0
            add_to_block(each.record.jaw, each.belief, each.scratch["update"])
    assert known.belief["block"]["largest"] > 5.0 * unknown.belief["block"]["largest"] > 0.0
