"""Readings filtered again: their likelihood, when, what is taken, and that slow or few ones are judged right."""

from dataclasses import replace

import newton_euler as twin
import numpy as np
import pytest
from recorded import recording
from running import Running
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from scipy.stats import multivariate_normal, norm

import jawenv
from agents import load_agent
from jawenv.envs.simulation import Simulation, configure
from jawenv.estimation.online import replay
from jawenv.estimation.online.record_filter import FilterRun, TensionFilter, belief_about, filter_record
from jawenv.estimation.online.state import begin_belief
from jawenv.estimation.online.tick import take_readings
from jawenv.estimation.recordings.thinning import divided, thinned

SWINGS = "opening_with_swings_and_fore_aft"


@pytest.fixture(scope="module")
def record():
    return recording().records[0]


def share(record, mean, cov):
    """NEES / 12."""
    error = mean - record.truth
    return error @ np.linalg.solve(cov, error) / len(error)


def run_about(record, parameters):
    """A run whose belief is ``parameters``, and the density that a replay of the whole record gives them."""
    run = FilterRun(record)
    jaw, device, belief, rows, settings, scratch = run.arguments
    begin_belief(settings["basis"], belief, parameters, settings["prior_sd"])
    return run, replay.replay(jaw, device, belief, rows, run.last, settings, scratch)


def test_misfit_is_the_likelihood_of_the_readings(record):
    """Each tick's readings at once, from the joint normal density that the filter predicts."""
    short = replace(record.until(0.5), gain_sd=0.0)
    running = Running(short)
    belief, expected = running.belief, 0.0
    constant = 0.5 * 12 * np.log(2.0 * np.pi)
    for k in range(len(short.samples) + 1):
        if k > 0:
            running.predict(k - 1)
        path = belief["motion"].copy()
        H = twin.derivative(lambda s: twin.measurement(short.jaw, s), path)
        S = H @ belief["motion_cov"] @ H.T + np.diag(running.variances)
        innovation = short.measured[k] - twin.measurement(short.jaw, path)
        expected -= multivariate_normal(cov=S, allow_singular=True).logpdf(innovation) + constant
        running.update(k)
    assert belief["misfit"] == pytest.approx(expected, abs=1e-4)


def test_density_has_the_gain_error_integrated_out_and_the_prior_in_it(record):
    """By quadrature over the gain error; the volume of the belief by NumPy."""
    short = record.until(1.0)
    parameters = short.prior.mean + 0.1
    running = Running(short, parameters).run(len(short.samples))
    score, known = running.belief["score"][-1], running.information[-1, -1]

    def log_likelihood(gain):
        return score * gain - 0.5 * known * gain**2 + norm.logpdf(gain, scale=short.gain_sd)

    best = minimize_scalar(lambda gain: -log_likelihood(gain), bounds=(-1.0, 1.0), options={"xatol": 1e-10}).x
    top, sd = log_likelihood(best), 1.0 / np.sqrt(known + short.gain_sd**-2)
    area, _ = quad(lambda gain: np.exp(log_likelihood(gain) - top), best - 12.0 * sd, best + 12.0 * sd, epsrel=1e-10)
    expected = top + np.log(area)
    expected -= running.belief["misfit"] + 0.5 * np.sum((0.1 / short.prior.sd) ** 2)
    run, density = run_about(short, parameters)
    expected += 0.5 * np.linalg.slogdet(run.belief["mode_cov"])[1]
    assert density == pytest.approx(expected, abs=1e-6)
    mean, cov = belief_about(short, parameters)
    np.testing.assert_array_equal(run.belief["mode_mean"], mean)
    np.testing.assert_array_equal(run.belief["mode_cov"], cov)


@pytest.mark.parametrize(
    ("pose_open", "expected"),
    [(False, [20, 40, 80]), (True, [20, 25, 32, 40, 50, 63, 79, 99, 124, 155, 194, 243, 304])],
    ids=["pose", "point"],
)
def test_windows_end_after_so_many_readings(record, pose_open, expected):
    """Every other tick's encoders are lost: ticks do not count, readings do."""
    run = FilterRun(record)
    _, _, belief, _, settings, scratch = run.arguments
    settings["pose_open"], found = pose_open, []
    for tick in range(700):
        scratch["used"] = tick % 2 == 0
        belief["read"] += tick % 2 == 0
        if replay.ends_window(belief, settings, scratch):
            found.append(int(belief["read"]))
            belief["window"] = belief["read"]
    assert found == expected


def test_readings_are_counted_where_an_encoder_is_believed(record):
    measured = record.measured.copy()
    measured[1::2] = np.nan
    run = FilterRun(replace(record, measured=measured))
    jaw, device, belief, rows, settings, scratch = run.arguments
    begin_belief(settings["basis"], belief, settings["prior_mean"], settings["prior_sd"])
    for tick in range(11):
        take_readings(jaw, device, belief, rows[tick]["measured"], rows[tick]["samples"], tick, settings, scratch)
    assert belief["read"] == 6


@pytest.mark.parametrize(
    ("model", "sensors", "expected"),
    [("jaw", "pose", False), ("jaw", "point", True), ("hinge", "point", False), ("bilateral", "point", True)],
)
def test_the_pose_is_open_where_there_are_fewer_readings_than_coordinates(model, sensors, expected):
    simulation = Simulation(1, configure({"model": model, "sensors": sensors}))
    assert bool(simulation.settings["filter"]["pose_open"][0]) is expected
    assert len(simulation.ticks[0]) == 1 + (3000 if expected else 320)


@pytest.mark.parametrize(("every", "expected"), [(1, False), (2, True), (5, True)])
def test_slow_encoders_leave_the_pose_open(record, every, expected):
    slow = divided(thinned(record, every), every)
    assert bool(FilterRun(slow).settings["pose_open"]) is expected


def test_starts_far_apart_come_to_the_mode_that_an_optimiser_finds(record):
    """With every reading of the pose there is one, wherever the search begins; what comes to it is not followed on."""
    short = record.until(1.0)
    run = FilterRun(short)
    jaw, device, belief, rows, settings, scratch = run.arguments
    arguments = jaw, device, belief, rows, run.last, settings, scratch
    starts = short.prior.mean + short.prior.sd * np.array([0.0, 1.5, -1.5])[:, None]
    replay.search(*arguments, starts, 16, 0.01)
    assert belief["n_modes"] == 1 and belief["others_weight"] == 0.0
    np.testing.assert_array_equal(belief["mean"], belief["mode_mean"])
    found = belief["mode_mean"].copy()
    for start in starts:
        density, new = replay.settle(*arguments, start.copy(), 16, 0.01)
        assert not new and np.isfinite(density)
        belief["n_modes"] = 0
        density, new = replay.settle(*arguments, start.copy(), 16, 0.01)
        assert new
        np.testing.assert_allclose(belief["mode_mean"] / short.prior.sd, found / short.prior.sd, rtol=0, atol=0.02)
        belief["n_modes"] = 1


def of_one_point(agent, seed, seconds):
    """A patient's record with the mouthpiece's position alone."""
    kwargs = {"sensors": "point", "record": True, "episode_s": seconds}
    return jawenv.play(load_agent(agent), patients=1, seed=seed, env_kwargs=kwargs).records[0]


def test_passes_that_jump_to_and_fro_are_damped():
    """Whole steps go on by 0.8 sds after a dozen passes of one point's readings; shorter ones settle."""
    record = of_one_point("hold_still", 6018, 4.75)
    whole, moved = record.prior.mean, []
    for _ in range(14):
        mean, cov = belief_about(record, whole)
        moved.append(np.max(np.abs(mean - whole) / np.sqrt(np.diag(cov))))
        whole = mean
    assert max(moved[-4:]) > 0.5
    run = FilterRun(record)
    jaw, device, belief, rows, settings, scratch = run.arguments
    _, new = replay.settle(jaw, device, belief, rows, run.last, settings, scratch, record.prior.mean.copy(), 16, 0.1)
    assert new and replay.distance(belief, scratch["about"]) < 0.2


def test_the_belief_covers_two_modes_of_which_the_wrong_one_is_denser():
    """A patient of one point whose readings fit two motions, the false one by four nats better."""
    record = of_one_point("hold_still", 6049, 10.0)
    estimate, run = TensionFilter().estimate(record), FilterRun(record)
    kept = np.empty((1, 12)), np.empty((1, 12, 12))
    filter_record(*run.arguments, len(record.measured), *kept)
    belief = run.belief
    found = [share(record, belief["modes_mean"][k], belief["modes_cov"][k]) for k in range(belief["n_modes"])]
    assert min(found) < 2.0 < 20.0 < max(found)
    assert share(record, belief["mode_mean"], belief["mode_cov"]) > 20.0
    assert share(record, estimate.mean[-1], estimate.cov[-1]) < 3.0


def test_modes_of_the_last_window_are_searched_again(record):
    """In the order: the mode, the others, the prior's mean, and the mode bent either way."""
    run = FilterRun(record)
    _, _, belief, _, settings, scratch = run.arguments
    sd, starts = settings["prior_sd"], scratch["starts"]
    belief["mode_mean"] = record.prior.mean + 0.3 * sd
    belief["n_modes"], belief["modes_density"][:3] = 3, [2.0, 5.0, 1.0]
    belief["modes_mean"][:3] = record.prior.mean + np.outer([1.0, 0.3, -1.0], sd)
    assert replay.set_starts(belief, settings, starts) == 6
    off = (starts[:6] - record.prior.mean) / sd
    for row, expected in zip(off[:4], [0.3, 1.0, -1.0, 0.0], strict=True):
        np.testing.assert_allclose(row, expected, atol=1e-9)
    bend = np.where(np.arange(12) % 2 == 0, np.where(np.arange(12) < 6, replay.APART, -replay.APART), 0.0)
    np.testing.assert_allclose(off[4], 0.3 + bend, atol=1e-9)
    np.testing.assert_allclose(off[5], 0.3 - bend, atol=1e-9)


def test_the_belief_hangs_less_on_the_guess_that_readings_were_filtered_at(record):
    """Twenty readings filtered at two guesses, a sd apart, then learned from; then filtered again."""
    before, after = [], []
    for guess in (-0.5, 0.5):
        run = FilterRun(record)
        jaw, device, belief, rows, settings, scratch = run.arguments
        replay.begin_motion(belief, rows[0]["believed"], settings["start_sd"])
        parameters = record.prior.mean + guess * record.prior.sd
        begin_belief(settings["basis"], belief, parameters, settings["prior_sd"])
        for tick in range(20):
            row = rows[tick]
            take_readings(jaw, device, belief, row["measured"], row["samples"], tick, settings, scratch)
        replay.learn(belief, settings, scratch)
        before.append(belief["mode_mean"] / np.sqrt(np.diag(belief["mode_cov"])))
        assert replay.ends_window(belief, settings, scratch)
        replay.renew(jaw, device, belief, rows, 19, settings, scratch)
        after.append(belief["mode_mean"] / np.sqrt(np.diag(belief["mode_cov"])))
    before, after = np.abs(before[1] - before[0]).max(), np.abs(after[1] - after[0]).max()
    assert before > 0.02
    assert after < 0.3 * before


@pytest.mark.parametrize("agent", [SWINGS, "hold_still"])
def test_slow_recordings_are_judged_right(agent):
    """Encoders read at 20 Hz, twelve patients, 15 s: an honest mean NEES/12 is 0.7 to 1.3; without replays it was 8."""
    played = jawenv.play(load_agent(agent), patients=12, seed=5000, env_kwargs={"record": True, "episode_s": 15.0})
    found = []
    for record in played.records:
        estimate = TensionFilter().estimate(divided(thinned(record, 5), 5))
        found.append(share(record, estimate.mean[-1], estimate.cov[-1]))
    assert 0.6 < np.mean(found) < 1.6


@pytest.mark.parametrize(("agent", "seconds"), [(SWINGS, 20.0), ("hold_still", 10.0)])
def test_one_point_is_judged_right_in_the_end(agent, seconds):
    """Eight patients; an honest mean NEES/12 is 0.6 to 1.4, without replays it was 85 and more, without others 6."""
    kwargs = {"sensors": "point", "episode_s": seconds}
    played = jawenv.play(load_agent(agent), patients=8, seed=5000, env_kwargs=kwargs)
    assert not played.terminated.any()
    error = played.belief_mean[:, -1] - played.truth
    found = [e @ np.linalg.solve(cov, e) / 12 for e, cov in zip(error, played.belief_cov[:, -1], strict=True)]
    assert 0.5 < np.mean(found) < 2.0


def test_a_record_that_is_lost_says_so(record):
    """Readings that make no sense leave a belief that is no number, or the prior's, and no endless search."""
    measured = np.full_like(record.measured, np.nan)
    run = FilterRun(replace(record, measured=measured))
    kept = np.empty((1, 12)), np.empty((1, 12, 12))
    filter_record(*run.arguments, len(measured), *kept)
    np.testing.assert_allclose(run.belief["mode_mean"], record.prior.mean)
    np.testing.assert_allclose(np.sqrt(np.diag(run.belief["mode_cov"])), record.prior.sd)
