"""The bias-separated filter against the dense joint Kalman filter with constant parameters, and finite differences."""

from dataclasses import replace

import newton_euler as twin
import numpy as np
import pytest
from recorded import SWINGS, recording
from running import Running, gain_columns, half_way, line_wrenches, rows_of

import jawenv
from agents import load_agent
from jawenv.filter.learn import recentre
from jawenv.filter.updates.measurement_update import REFUSED


class Joint:
    """The dense Kalman filter over motion, coefficients and gain error, linearised at another filter's path."""

    def __init__(self, running):
        self.running, n = running, running.size
        self.sd = np.append(np.full(running.columns - 2, 2.0), [running.record.gain_sd] * 2)
        self.mean = np.concatenate([running.belief["motion"], np.zeros(running.columns)])  # of c: from the nominal
        self.P = np.zeros((n + running.columns,) * 2)
        self.P[:n, :n], self.P[n:, n:] = running.belief["motion_cov"], np.diag(self.sd**2)

    def predict(self, k):
        running, record, n = self.running, self.running.record, self.running.size
        before, trend = running.belief["motion"].copy(), running.belief["trend"].copy()
        running.predict(k)
        after = running.belief["motion"].copy()
        A, G = np.split(running.scratch["time"]["step"]["total"], [n], axis=1)
        middle = half_way(record.jaw, before, running.led(before))
        lines = line_wrenches(record.jaw, running.belief["basis"], *middle, *gain_columns(running, before, trend))
        F = np.eye(len(self.mean))
        F[:n, :n], F[:n, n:] = A, G @ lines
        self.P = F @ self.P @ F.T
        self.P[:n, :n] += G @ np.diag(record.noise_variance[:6]) @ G.T
        self.mean = F @ (self.mean - np.concatenate([before, np.zeros(running.columns)]))
        self.mean[:n] += after

    def update(self, k, used):
        running, n, chosen = self.running, self.running.size, used.astype(bool)
        path = running.belief["motion"].copy()
        H = np.zeros((12, len(self.mean)))
        H[:, :n] = rows_of(running.record.jaw, running.belief["predicted"])
        expected = running.expected() + H[:, :n] @ (self.mean[:n] - path)
        H, R = H[chosen], np.diag(running.settings["measurement_variance"][chosen])
        K = self.P @ H.T @ np.linalg.inv(H @ self.P @ H.T + R)
        self.mean = self.mean + K @ (running.record.measured[k] - expected)[chosen]
        rest = np.eye(len(self.mean)) - K @ H
        self.P = rest @ self.P @ rest.T + K @ R @ K.T
        assert running.update(k, used) != REFUSED


@pytest.mark.parametrize("early", [True, False], ids=["early", "late"])
def test_the_separated_filter_is_the_joint_one(early, rng):
    """The joint belief from the separated one and the prior that the joint one needs, after 100 ticks with holes."""
    running = Running(recording("jaw", cohort="healthy").records[0], early=early)
    joint, n = Joint(running), running.size
    for k in range(101):
        if k > 0:
            joint.predict(k - 1)
        joint.update(k, (rng.random(12) > 0.3).astype(np.uint8))
    precision = running.information + np.diag(joint.sd**-2.0)
    cov = np.linalg.inv(precision)
    mean = cov @ running.score
    V = running.by_tension
    sd = np.sqrt(np.diag(joint.P))
    expected = np.block([[running.belief["motion_cov"] + V @ cov @ V.T, V @ cov], [cov @ V.T, cov]])
    assert np.abs((joint.P - expected) / np.outer(sd, sd)).max() < 1e-7
    whole = np.concatenate([running.belief["motion"] + V @ mean, mean])
    assert np.abs((joint.mean - whole) / sd).max() < 1e-6
    assert (sd[n:] / joint.sd).min() < 0.3 and np.abs(mean / joint.sd).max() > 0.3, "the record teaches something"
    information = running.belief["information"]
    np.testing.assert_array_equal(information[running.columns :], 0.0)
    np.testing.assert_array_equal(running.belief["score"][running.columns :], 0.0)


def test_motion_and_score_of_another_patient_from_those_of_this_one(rng):
    """Finite differences: run at other parameters, or run and moved there by ``recentre``.

    On readings without innovations: what those are multiplied by depends on the patient too, which no such filter
    differentiates. Lines and the Jacobian are taken half way through a step: that costs up to 6 % of
    the score's change.
    """
    kwargs = {"record": True, "episode_s": 1.0}
    record = jawenv.play(load_agent(SWINGS, control="force"), patients=1, seed=5000, env_kwargs=kwargs).records[0]
    record = Running(record).foresee(80)
    theta = record.prior.mean + 1e-3 * rng.uniform(0.5, 1.5, len(record.prior.mean))
    other, moved, stayed = Running(record, theta).run(80), Running(record).run(80), Running(record).run(80)
    moved.belief["mean"] = theta
    recentre(moved.belief, moved.settings, moved.scratch["belief"])
    difference = other.belief["motion"] - stayed.belief["motion"]
    sd = np.sqrt(np.diag(stayed.belief["motion_cov"]))
    wrong = other.belief["motion"] - moved.belief["motion"]
    assert np.abs(wrong / sd).max() < 0.05 * np.abs(difference / sd).max()
    np.testing.assert_array_equal(moved.belief["nominal"], other.belief["nominal"])
    told = np.diag(stayed.information) > 0.0
    scale = np.sqrt(np.diag(stayed.information)[told])
    change, wrong = ((other.score - each.score)[told] / scale for each in (stayed, moved))
    assert np.abs(wrong).max() < 0.1 * np.abs(change).max()


def test_without_gain_error_its_column_stays_apart():
    """The coefficients' information does not depend on what is believed of the gain: it is integrated out later."""
    record = recording().records[0]
    sure, unsure = (Running(replace(record, gain_sd=sd)).run(60) for sd in (0.0, 0.1))
    np.testing.assert_array_equal(sure.information, unsure.information)
    assert np.abs(sure.information[-2]).max() > 0.0
    assert twin.measurement(record.jaw, sure.belief["motion"]) == pytest.approx(sure.expected(), abs=1e-12)
