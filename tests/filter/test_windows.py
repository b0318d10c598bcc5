"""Readings filtered again: when, from where, what it is good for, and that slow or few ones are judged right."""

from dataclasses import replace

import numpy as np
import pytest
from recorded import SWINGS, opening, share
from running import FilterRun

import jawenv
from agents import load_agent
from jawenv.envs.configuration import configure
from jawenv.envs.simulation import Simulation
from jawenv.filter.belief.state import begin_belief, begin_motion
from jawenv.filter.learn import learn
from jawenv.filter.tick import (
    CONVERGED_SD,
    LAST_WINDOW,
    MOVED,
    ends_window,
    has_moved,
    replay,
    take_readings,
)
from jawenv.filter.updates.measurement_update import SURPRISING
from jawenv.metrics.calibration import nees, nees_band
from jawenv.recordings.dividing import divided
from jawenv.recordings.online import take_tick
from jawenv.recordings.record_filter import TensionFilter
from jawenv.recordings.thinning import thinned


@pytest.fixture(scope="module")
def record():
    """Off the teeth throughout: every reading teaches."""
    return opening("healthy").records[0]


def filter_tick(run, tick, every=1_000_000):
    """One tick of the filter in a control period that does not end, or ends every so many ticks; what it returns."""
    jaw, belief, kept, rows, settings, scratch = run.arguments
    return take_tick(jaw, (belief, kept), rows, (tick, every), *doubles(rows[tick]), settings, scratch)


def doubles(row):
    """The readings of a row, in double precision."""
    return row["measured"].astype(float), row["samples"].astype(float)


def test_windows_end_after_so_many_readings(record):
    belief, ends = FilterRun(record).belief, []
    for readings in (*range(1500), LAST_WINDOW - 1, LAST_WINDOW, 2 * LAST_WINDOW):
        belief["readings"] = readings
        if ends_window(belief):
            ends.append(readings)
    assert ends == [5, 10, 20, 40, 80, 160, 320, 640, 1280, LAST_WINDOW]


def test_readings_are_counted_where_an_encoder_is_used(record):
    measured = record.measured.copy()
    measured[1::2] = np.nan
    jaw, belief, _, rows, settings, scratch = FilterRun(replace(record, measured=measured)).arguments
    begin_belief(settings["basis"], belief, settings["prior_mean"], settings["prior_sd"])
    for tick in range(11):
        take_readings(jaw, belief, *doubles(rows[tick]), tick, settings, scratch)
    assert belief["readings"] == 6


def test_as_many_ticks_are_kept_as_the_last_window_needs():
    for seconds, ticks in ((5.0, 500), (300.0, LAST_WINDOW)):
        configuration = configure({"model": "jaw", "control": "force", "episode_s": seconds})
        assert len(Simulation(1, configuration).ticks[0]) == 1 + ticks


def filtered_until(record, guess, ticks):
    """A run whose readings were filtered as if the muscles were a ``guess`` of so many prior sds."""
    run = FilterRun(record)
    jaw, belief, _, rows, settings, scratch = run.arguments
    begin_motion(belief, belief["began"], settings["start_sd"])
    begin_belief(settings["basis"], belief, record.prior.mean + guess * record.prior.sd, settings["prior_sd"])
    for tick in range(ticks):
        take_readings(jaw, belief, *doubles(rows[tick]), tick, settings, scratch)
    learn_wholly(run.arguments)
    return run


def learn_wholly(arguments):
    """All steps of the linearisation, however far the guess was."""
    for _ in range(20):
        learn(arguments.belief, arguments.settings, arguments.scratch["belief"])


def test_the_belief_hangs_less_on_the_guess_that_readings_were_filtered_at(record):
    """Twenty readings filtered at two guesses, a sd apart, then learned from; then filtered again."""
    before, after = [], []
    for guess in (-0.5, 0.5):
        arguments = filtered_until(record, guess, 20).arguments
        jaw, belief, kept, rows, settings, scratch = arguments
        before.append(belief["mean"] / np.sqrt(np.diag(belief["cov"])))
        replay(jaw, (belief, kept), rows, 19, settings, scratch)
        learn_wholly(arguments)
        after.append(belief["mean"] / np.sqrt(np.diag(belief["cov"])))
    before, after = np.abs(before[1] - before[0]).max(), np.abs(after[1] - after[0]).max()
    assert before > 0.02
    assert after < 0.3 * before


def test_a_replay_forgets_what_was_gathered_and_keeps_the_belief(record):
    """Filtering from the first reading at that belief gives the same bits."""
    run = filtered_until(record, 0.0, 40)
    jaw, belief, kept, rows, settings, scratch = run.arguments
    mean, cov = belief["mean"].copy(), belief["cov"].copy()
    rows["measured"][30, 0] += 0.01
    replay(jaw, (belief, kept), rows, 39, settings, scratch)
    np.testing.assert_array_equal(belief["mean"], mean)
    np.testing.assert_array_equal(belief["cov"], cov)
    again = belief.copy()
    replay(jaw, (belief, kept), rows, 39, settings, scratch)
    for name in ("motion", "motion_cov", "by_tension", "information", "score", "trend", "readings"):
        np.testing.assert_array_equal(belief[name], again[name])
    assert belief["readings"] == 40


def test_ends_of_windows_and_surprises_renew_the_belief(record):
    """The others leave it to the end of the control period, which leaves the point of linearisation where it is."""
    run = FilterRun(record)
    _, belief, _, rows, settings, scratch = run.arguments
    far = settings["prior_mean"] + 3.0 * settings["prior_sd"]
    begin_belief(settings["basis"], belief, far, settings["prior_sd"])
    begin_motion(belief, belief["began"], settings["start_sd"])
    changed, surprising = {"mean": [], "point": []}, []
    for tick in range(100):
        before = {name: belief[name].copy() for name in changed}
        filter_tick(run, tick, every=8)
        for name, ticks in changed.items():
            if (belief[name] != before[name]).any():
                ticks.append(tick)
        if scratch["verdict"] == SURPRISING:
            surprising.append(tick)
    assert surprising
    assert changed["point"] == sorted({4, 9, 19, 39, 79, *surprising})
    assert changed["mean"] == sorted({*changed["point"], *range(8, 100, 8)})


@pytest.mark.parametrize(
    ("moved", "sd", "expected"), [(0.99 * MOVED, 1e-3, False), (1.01 * MOVED, 1e-3, True), (0.1, 0.08, False)]
)
def test_readings_are_filtered_again_where_a_mean_has_moved_far_and_by_its_sds(record, moved, sd, expected):
    belief = FilterRun(record).belief
    assert not has_moved(belief)
    belief["mean"][7] -= moved
    belief["cov"][7, 7] = sd * sd
    assert has_moved(belief) is expected


def test_old_readings_are_not_filtered_again_once_the_muscles_are_nearly_known():
    """What spoils rows that were read then goes unnoticed."""
    kwargs = {"record": True, "cohort": "severe", "episode_s": 10.0, "track_bound": False}
    played, later = jawenv.play(load_agent("refined"), patients=12, seed=5000, env_kwargs=kwargs), 0
    for record in played.records:
        whole, changed, since = FilterRun(record), FilterRun(record), None
        for tick in range(len(record.time)):
            for run in (whole, changed):
                filter_tick(run, tick, every=8)
            if since is None and np.diag(whole.belief["cov"]).max() < 0.9 * CONVERGED_SD**2:
                since = int(whole.belief["replayed"])
                changed.arguments.rows["measured"][: since + 1] = np.nan
        later += since is not None and int(whole.belief["replayed"]) > since
        np.testing.assert_array_equal(whole.belief["mean"], changed.belief["mean"])
        np.testing.assert_array_equal(whole.belief["cov"], changed.belief["cov"])
    assert later, "of some patient a later window moved the mean"


def test_a_replay_says_where_it_was_made(record):
    jaw, belief, kept, rows, settings, scratch = filtered_until(record, 0.0, 300).arguments
    assert has_moved(belief)
    replay(jaw, (belief, kept), rows, 299, settings, scratch)
    assert not has_moved(belief)


def test_slow_recordings_are_judged_right():
    """Encoders read at 20 Hz; without replays mean NEES/12 was 8."""
    kwargs = {"record": True, "episode_s": 10.0, "track_bound": False}
    played = jawenv.play(load_agent(SWINGS, control="force"), patients=16, seed=5000, env_kwargs=kwargs)
    shares = []
    for record in played.records:
        estimate = TensionFilter().estimate(divided(thinned(record, 5), 5))
        shares.append(share(record, estimate.mean[-1], estimate.cov[-1]))
    low, high = np.array(nees_band(16, 12, 0.999)) / 12.0
    assert low < np.mean(shares) < high


def test_one_point_is_judged_right_in_most():
    """Seven of twelve patients at least; where more than one motion fits, no filter knows."""
    kwargs = {"sensors": "point", "episode_s": 15.0, "track_bound": False}
    played = jawenv.play(load_agent(SWINGS, control="force"), patients=12, seed=5000, env_kwargs=kwargs)
    assert not played.terminated.any()
    shares = nees(played.belief_mean[:, -1] - played.truth, played.belief_cov[:, -1]) / 12.0
    assert np.sum(shares < 2.5) >= 7, shares


def test_a_record_that_says_nothing_leaves_the_prior(record):
    blind = replace(record, measured=np.full_like(record.measured, np.nan))
    estimate = TensionFilter().estimate(blind)
    np.testing.assert_allclose(estimate.mean[-1], record.prior.mean)
    np.testing.assert_allclose(estimate.sd[-1], record.prior.sd)


def test_refused_ticks_are_counted_once_whatever_is_filtered_again(record):
    """Hostile readings, and readings that are filtered again behind them: no tick counts for more than one."""
    measured = record.measured.copy()
    measured[8:19:2, 0] += 0.02
    run = FilterRun(replace(record, measured=measured))
    _, belief, _, rows, settings, _ = run.arguments
    begin_belief(settings["basis"], belief, settings["prior_mean"], settings["prior_sd"])
    begin_motion(belief, belief["began"], settings["start_sd"])
    counted, replayed = [], []
    for tick in range(100):
        before, place = sum(counted), belief["replayed_at"].copy()
        counted.append(filter_tick(run, tick)[1])
        if (belief["replayed_at"] != place).any():
            replayed.append((tick, before))
    assert any(before >= 2 for _, before in replayed), "readings are filtered again after some were refused"
    assert sum(counted) >= 4
