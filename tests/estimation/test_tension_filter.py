"""The environments' filter: against the dense joint Kalman filter, finite differences, and itself in the world."""

from dataclasses import replace
from functools import cache

import newton_euler as twin
import numpy as np
import pytest
from recorded import Waves, recording
from running import Running, half_way, line_wrenches

import jawenv
from agents import load_agent
from jawenv.device.device import Device
from jawenv.estimation.online.record_filter import TensionFilter
from jawenv.estimation.online.regressors import middle_of, set_by_place, set_line_wrenches
from jawenv.estimation.online.state import recentre
from jawenv.metrics.calibration import nees

SWINGS = "opening_with_swings_and_fore_aft"
FAULTS = {"lost_share": 0.2, "frozen_share": 0.2}


@pytest.mark.parametrize("model", ["jaw", "hinge", "bilateral"])
def test_the_wrench_of_unit_coefficients(model, rng):
    record = recording(model).records[0]
    running = Running(record)
    before, scratch = record.start_mean.copy(), running.scratch
    after = before + 1e-3 * rng.normal(size=len(before))
    scratch["reading"], scratch["spilt"] = rng.normal(size=6), 0.0
    q, place = middle_of(record.jaw, before, after)
    R = twin.rotation(np.array(q))
    rows = tuple(tuple(float(value) for value in row) for row in R)
    bend = set_by_place(record.jaw, q, rows, scratch)
    set_line_wrenches(record.jaw, running.belief, place, rows, bend, record.dt, scratch)
    expected = line_wrenches(record.jaw, running.basis, *half_way(record.jaw, before, after), scratch["reading"])
    np.testing.assert_allclose(scratch["line_wrench"], expected, rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(running.belief["score"], 0.0)


class Joint:
    """The dense Kalman filter over motion, coefficients and gain error, linearised at another filter's path."""

    def __init__(self, running):
        self.running, n = running, running.size
        columns = running.belief["by_tension"].shape[1]
        self.sd = np.append(np.full(columns - 1, 2.0), running.record.gain_sd)
        self.mean = np.concatenate([running.belief["motion"], np.zeros(columns)])  # deviations of c from the nominal
        self.P = np.zeros((n + columns, n + columns))
        self.P[:n, :n], self.P[n:, n:] = running.belief["motion_cov"], np.diag(self.sd**2)

    def predict(self, k):
        running, record, n = self.running, self.running.record, self.running.size
        before, trend = running.belief["motion"].copy(), running.belief["trend"].copy()
        running.predict(k)
        after = running.belief["motion"].copy()
        A, G = running.scratch["total"][:, :n].copy(), running.scratch["total"][:, n + 1 :].copy()
        F = np.eye(len(self.mean))
        F[:n, :n] = A
        answers = running.scratch["answer"].any()
        reading = trend if answers else np.array([1.0, 4.0, 1.0]) @ record.samples[k] / 6.0
        calm = running.belief["strain_mean"], running.scratch["kept"]
        lines = line_wrenches(record.jaw, running.basis, *half_way(record.jaw, before, after), reading, *calm)
        F[:n, n:] = G[:, :6] @ lines
        self.P = F @ self.P @ F.T
        self.P[:n, :n] += G @ np.diag(record.noise_variance) @ G.T
        self.mean = F @ (self.mean - np.concatenate([before, 0.0 * self.mean[n:]]))
        self.mean[:n] += after

    def update(self, k, used):
        running, n, chosen = self.running, self.running.size, used.astype(bool)
        path = running.belief["motion"].copy()
        H = np.zeros((12, len(self.mean)))
        H[:, :n] = twin.derivative(lambda s: twin.measurement(running.record.jaw, s), path)
        expected = twin.measurement(running.record.jaw, path) + H[:, :n] @ (self.mean[:n] - path)
        H, R = H[chosen], np.diag(running.variances[chosen])
        K = self.P @ H.T @ np.linalg.inv(H @ self.P @ H.T + R)
        self.mean = self.mean + K @ (running.record.measured[k] - expected)[chosen]
        rest = np.eye(len(self.mean)) - K @ H
        self.P = rest @ self.P @ rest.T + K @ R @ K.T
        running.update(k, used)


def without_cell_noise(record):
    """Of what is unknown of the wrench no part is the cell's, and nothing answers: motion and reading share none."""
    return replace(record, cell_sd=np.zeros(6), device=None)


@pytest.mark.parametrize("model", ["jaw", "bilateral"])
def test_without_cell_noise_and_answer_an_estimate_is_uncorrelated_with_its_error(model, rng):
    """Then nothing is taken from the score: ``tremble`` is the covariance, however far ahead one looks."""
    record = without_cell_noise(recording(model).records[0])
    running = Running(record)
    sd = np.sqrt(np.maximum(np.diag(running.belief["motion_cov"]), 1e-30))
    taken = np.zeros_like(running.belief["score"])
    for k in range(60):
        running.update(k, (rng.random(12) > 0.3).astype(np.uint8))
        before, information = running.belief["score"].copy(), running.belief["information"].copy()
        running.predict(k)
        P, C = running.belief["motion_cov"], running.belief["tremble"]
        np.testing.assert_allclose(C / np.outer(sd, sd), P / np.outer(sd, sd), rtol=1e-8, atol=1e-11)
        taken += np.abs(running.belief["score"] - before)
        np.testing.assert_array_equal(running.belief["information"], information)
    assert (taken < 1e-8 * np.sqrt(np.diag(running.information))).all()
    assert np.abs(running.belief["aftermath"]).max() > 0.0


@pytest.mark.parametrize(("control", "brake"), [("force", 0.0), ("force", 30.0), ("trajectory", 0.0)])
def test_the_separated_filter_is_the_joint_one(rng, control, brake):
    """The joint belief from the separated one and the prior that the joint one needs, after 100 ticks with holes.

    What the score owes to the device's answer is left to its own test.
    """
    record = replace(without_cell_noise(recording().records[0]), device=Device(brake_N_s_m=brake), control=control)
    running = Running(record)
    joint, n, braked = Joint(running), running.size, 0
    for k in range(101):
        if k > 0:
            joint.predict(k - 1)
            braked += control == "force" and running.scratch["answer"].any()
        joint.update(k, (rng.random(12) > 0.3).astype(np.uint8))
    assert braked > 10 if brake else braked == 0
    precision = running.information + np.diag(joint.sd**-2.0)
    cov = np.linalg.inv(precision)
    mean = cov @ running.belief["score"]
    V = running.belief["by_tension"]
    sd = np.sqrt(np.diag(joint.P))
    expected = np.block([[running.belief["motion_cov"] + V @ cov @ V.T, V @ cov], [cov @ V.T, cov]])
    assert np.abs((joint.P - expected) / np.outer(sd, sd)).max() < 1e-8
    if control == "force" and brake == 0.0:
        whole = np.concatenate([running.belief["motion"] + V @ mean, mean])
        assert np.abs((joint.mean - whole) / sd).max() < 1e-7
    assert (sd[n:] / joint.sd).min() < 0.3 and np.abs(mean / joint.sd).max() > 0.3, "the record teaches something"
    np.testing.assert_array_equal(running.belief["motion_cov"], running.belief["motion_cov"].T)


@pytest.mark.parametrize("model", ["jaw", "hinge", "bilateral"])
def test_motion_and_score_of_another_patient_from_those_of_this_one(model, rng):
    """Finite differences: run at other parameters, or run and moved there by ``recentre``.

    On readings without innovations: what those are multiplied by depends on the patient too, which no such filter
    differentiates. Lines are taken half way through a step, and teeth as steep as where they have been of late;
    measured, it costs 1.0, 3.2 and 0.4 % of the difference.
    """
    kwargs = {"record": True, "model": model, "episode_s": 1.0}
    record = jawenv.play(load_agent(SWINGS), patients=1, seed=5000, env_kwargs=kwargs).records[0]
    record = Running(without_cell_noise(record)).foresee(80)
    theta = record.prior.mean + 1e-3 * rng.uniform(0.5, 1.5, len(record.prior.mean))
    other, moved, stayed = Running(record, theta).run(80), Running(record).run(80), Running(record).run(80)
    moved.belief["mode_mean"] = theta
    recentre(moved.belief, moved.scratch)
    free = record.start_sd > 0.0
    difference = (other.belief["motion"] - stayed.belief["motion"])[free]
    sd = np.sqrt(np.diag(stayed.belief["motion_cov"]))[free]
    wrong = (other.belief["motion"] - moved.belief["motion"])[free]
    assert np.abs(wrong / sd).max() < 0.05 * np.abs(difference / sd).max()
    np.testing.assert_array_equal(moved.belief["nominal"], other.belief["nominal"])
    scale = np.sqrt(np.diag(stayed.information))
    change = (other.belief["score"] - stayed.belief["score"]) / scale
    wrong = (other.belief["score"] - moved.belief["score"]) / scale
    assert np.abs(wrong).max() < 0.1 * np.abs(change).max(), "0.06 for the jaw, from the first ticks"


@cache
def played(env_id, faulty, **more):
    kwargs = {"record": True, "episode_s": 3.0, "reality": FAULTS if faulty else None, **more}
    return jawenv.play(Waves(), patients=2, seed=5000, env_id=env_id, env_kwargs=kwargs)


@pytest.mark.parametrize("env_id", ["jawenv/Jaw-v0", "jawenv/JawHinge-v0", "jawenv/JawBilateral-v0"])
@pytest.mark.parametrize("faulty", [False, True], ids=["sound", "faulty"])
def test_a_record_gives_the_environments_belief_to_the_bit(env_id, faulty):
    run = played(env_id, faulty)
    for i, record in enumerate(run.records):
        estimate = TensionFilter().estimate(record)
        np.testing.assert_array_equal(estimate.mean, run.belief_mean[i])
        np.testing.assert_array_equal(estimate.cov, run.belief_cov[i])
        assert np.isnan(record.measured).any() == faulty


def test_a_record_of_one_point_gives_the_environments_belief_to_the_bit():
    run = played("jawenv/Jaw-v0", True, sensors="point", control="trajectory", control_hz=10)
    estimate = TensionFilter(every=10).estimate(run.records[0])
    np.testing.assert_array_equal(estimate.mean, run.belief_mean[0])
    np.testing.assert_array_equal(estimate.cov, run.belief_cov[0])


def test_every_is_checked():
    with pytest.raises(jawenv.InputError, match="^every: 0 given, allowed is 1 or more$"):
        TensionFilter(every=0)


def believing(record):
    """The record with what froze made a number that has changed: by its last bit."""
    measured, samples = record.measured.copy(), record.samples.copy()
    for k in range(1, len(measured)):
        same = measured[k] == measured[k - 1]
        measured[k, same] = np.nextafter(measured[k, same], np.inf)
    last = np.full(6, np.nan)
    for rows in samples:
        for row in rows:
            same = row == last
            row[same] = np.nextafter(row[same], np.inf)
            last = row
    return replace(record, measured=measured, samples=samples)


def test_what_failed_is_left_out_and_must_be():
    """A third of the readings. Measured: mean NEES 14, and 20 for a filter that believes the frozen ones."""
    kwargs = {"record": True, "episode_s": 15.0, "reality": FAULTS}
    run = jawenv.play(load_agent(SWINGS), patients=12, seed=40_000, env_kwargs=kwargs)
    assert not run.terminated.any()
    assert np.isfinite(run.belief_cov).all()
    of_belief = nees(run.at_end(run.belief_mean) - run.truth, run.at_end(run.belief_cov))
    naive = [TensionFilter().estimate(believing(record)) for record in run.records]
    of_naive = nees(np.array([e.mean[-1] for e in naive]) - run.truth, np.array([e.cov[-1] for e in naive]))
    assert np.mean(of_belief) < 20.0
    assert np.mean(of_naive) > np.mean(of_belief)


def test_a_sensor_that_dies_costs_information_alone():
    """An encoder of angles stops after 3 s. Measured: NEES 10 to 23, and 130,000 for a filter that believes it."""
    run = jawenv.play(load_agent(SWINGS), patients=4, seed=40_000, env_kwargs={"record": True, "episode_s": 15.0})
    of_belief, of_naive = [], []
    for record in run.records:
        measured = record.measured.copy()
        measured[300:, 4] = measured[300, 4]
        dead = replace(record, measured=measured)
        for into, given in ((of_belief, dead), (of_naive, believing(dead))):
            estimate = TensionFilter().estimate(given)
            error = estimate.mean[-1] - record.truth
            into.append(error @ np.linalg.solve(estimate.cov[-1], error))
    assert max(of_belief) < 40.0
    assert np.nan_to_num(of_naive, nan=np.inf).min() > 1000.0, "it is lost, or broken"


@pytest.mark.parametrize(("name", "settles"), [("Jaw", False), ("JawBilateral", True)])
def test_a_jaw_on_two_discs_is_not_judged_while_it_settles(name, settles):
    """For 0.1 s nothing is learned; then the claims hold: without that, mean NEES/12 of 9 after 2 s."""
    run = jawenv.play(
        load_agent(SWINGS), patients=16, seed=5000, env_id=f"jawenv/{name}-v0", env_kwargs={"episode_s": 2.0}
    )
    learned = run.information_claimed[:, 1]
    np.testing.assert_allclose(learned, 0.0, atol=1e-9) if settles else np.testing.assert_array_less(1.0, learned)
    assert (run.information_claimed[:, 3] > 1.0).all()
    error = run.belief_mean[:, -1] - run.truth
    nees = np.einsum("ni,nij,nj->n", error, np.linalg.inv(run.belief_cov[:, -1]), error)
    assert nees.mean() / 12 < 1.6
