"""The environments' filter along a record, step by step, and what its kernels compute in plain NumPy."""

from collections import namedtuple
from dataclasses import replace

import newton_euler as twin
import numpy as np

from jawenv.filter.belief.state import begin_belief, begin_motion, belief_dtype, shared_columns
from jawenv.filter.model.encoders import measure
from jawenv.filter.readings.cell_trend import SMOOTHING_TIME, follow_trend
from jawenv.filter.tick import ROW, begin_filter, filter_scratch_dtype
from jawenv.filter.updates.instrument import FIRST_READINGS
from jawenv.filter.updates.measurement_update import update_motion
from jawenv.filter.updates.time_update import predict_motion
from jawenv.kernels.linalg import mirror
from jawenv.kernels.records import record_zeros
from jawenv.mechanics.dynamics import N_WRENCH
from jawenv.recordings.filter_settings import settings_of_record

ALL = np.ones(12, dtype=np.uint8)


Arguments = namedtuple("Arguments", "jaw belief kept rows settings scratch")
"""Arguments of the kernels that filter a record; ``kept`` is the belief as the last replay left it."""


class FilterRun:
    """The kernels' inputs for the filter of a record: the jaw, and memory as before the first reading."""

    def __init__(self, record):
        states, muscles = len(record.start_mean), len(record.parameter_names) // 2
        settings = settings_of_record(record)
        rows = record_zeros(len(record.time), ROW)
        rows["measured"], rows["samples"][1:] = record.measured, record.samples
        self.belief, kept = record_zeros(2, belief_dtype(muscles, states))
        scratch = record_zeros(1, filter_scratch_dtype(muscles, len(record.jaw["l_o"]), states))[0]
        begin_filter(record.jaw, self.belief, record.start_mean, settings)
        self.arguments = Arguments(record.jaw, self.belief, kept, rows, settings, scratch)


class Running:
    """The filter's motion and information along a record, at a belief that stays ``log_parameters``.

    ``early``: as at the first readings of an episode.
    """

    def __init__(self, record, log_parameters=None, early=True):
        self.record, self.size = record, len(record.start_mean)
        run = FilterRun(record)
        _, self.belief, _, _, self.settings, self.scratch = run.arguments
        theta = record.prior.mean.copy() if log_parameters is None else log_parameters
        begin_belief(self.settings["basis"], self.belief, theta, record.prior.sd.copy())
        begin_motion(self.belief, record.start_mean.copy(), record.start_sd.copy())
        self.belief["readings"] = 0 if early else FIRST_READINGS
        self.columns = self.belief["nominal"].size + shared_columns(0)  # the rest is zero

    def predict(self, k):
        record = self.record
        noise = record.noise_variance[:N_WRENCH].copy()
        predict_motion(record.jaw, self.belief, record.samples[k], noise, self.settings, self.scratch["time"])
        follow_trend(self.belief["trend"], record.samples[k], record.dt)
        follow_trend(self.belief["smoothed"], record.samples[k], record.dt, SMOOTHING_TIME)

    def led(self, before):
        """The end of the tick from the motion ``before``, half way to which the muscle lines lie."""
        early = self.belief["readings"] < FIRST_READINGS
        return coasted(before, self.record.dt) if early else self.belief["predicted"]

    def update(self, k, used=ALL):
        """What explains the readings of row ``k``."""
        return self.take(self.record.measured[k], used)

    def take(self, measured, used=ALL):
        scratch = self.scratch["update"]
        return update_motion(self.record.jaw, self.belief, measured, used, 1.0, self.settings, scratch)

    def expected(self):
        """(12,) readings to measure."""
        measure(
            self.record.jaw, self.belief["motion"], self.scratch["update"]["rows"], self.scratch["update"]["expected"]
        )
        return self.scratch["update"]["expected"].copy()

    def foresee(self, ticks):
        """The record with readings that this filter expects to the last bit: without innovations."""
        measured = self.record.measured.copy()
        self.record = replace(self.record, measured=measured)
        for k in range(ticks + 1):
            if k > 0:
                self.predict(k - 1)
            measured[k] = self.expected()
            self.update(k)
        return self.record

    def run(self, ticks):
        self.update(0)
        return self.run_on(0, ticks)

    def run_on(self, first, last):
        """From the end of tick ``first`` to that of ``last``; the information is whole then, as where the belief is."""
        for k in range(first, last):
            self.predict(k)
            self.update(k + 1)
        mirror(self.belief["information"])
        return self

    @property
    def information(self):
        upper = np.triu(self.belief["information"][: self.columns, : self.columns])
        return upper + np.triu(upper, 1).T

    @property
    def score(self):
        return self.belief["score"][: self.columns].copy()

    @property
    def by_tension(self):
        return self.belief["by_tension"][:, : self.columns].copy()


def line_wrenches(jaw, basis, place, R, *shared):
    """(6, mK + S) at the mouthpiece, body axes, of unit coefficients, and the S ``shared`` ones behind them."""
    n, K = basis["nodes"].shape
    wrenches = np.zeros((6, n * K + len(shared)))
    for line in range(len(jaw["l_o"])):
        insertion = place + R @ jaw["insertion"][line]
        reach, muscle = jaw["origin"][line] - insertion, jaw["muscle"][line]
        strain = np.linalg.norm(reach) / jaw["l_o"][line] - 1.0 - basis["centre"][muscle]
        force = reach / np.linalg.norm(reach)
        moment = np.cross(insertion - (place + R @ jaw["mouthpiece"]), force)
        wrench = np.concatenate([R.T @ force, R.T @ moment])
        for k in range(K):
            wrenches[:, muscle * K + k] += np.exp(basis["nodes"][muscle, k] * strain) * wrench
    wrenches[:, n * K :] = np.transpose(shared)
    return wrenches


def gain_columns(running, before, trend):
    """Two wrenches (6,): ``trend`` changed so that a jaw at rest half way from ``before`` stays; of its acceleration.

    By a force at the mouthpiece that is tangential to the fossa, and a moment.
    """
    jaw, unknown = running.record.jaw, np.zeros((5, 6))
    pose = 0.5 * (before + running.led(before))[:5]
    tangents = np.array([[1.0, 0.0, twin.fossa(jaw, pose[0])[1]], [0.0, 1.0, 0.0]])
    unknown[:2, :3], unknown[2:, 3:] = tangents @ twin.rotation(pose), np.eye(3)

    def acceleration(wrench):
        return twin.state_rate(jaw, running.belief["point"], np.concatenate([pose, np.zeros(5)]), wrench)[5:]

    found = acceleration(trend)
    by_unknown = np.array([acceleration(trend + wrench) - found for wrench in unknown]).T
    early = running.belief["readings"] < FIRST_READINGS
    rate = np.zeros(5) if early else (running.belief["predicted"] - before)[5:] / running.record.dt
    return trend - unknown.T @ np.linalg.solve(by_unknown, found), unknown.T @ np.linalg.solve(by_unknown, rate)


def half_way(jaw, before, after):
    """The reference point's place and the rotation half way between two states."""
    q = 0.5 * (before + after)
    return twin.contact(jaw, q[:5]), twin.rotation(q[:5])


def coasted(state, dt):
    """The pose after ``dt`` at the rates of ``state``, those of the angles from R^T R'; the rates are not moved."""
    half = len(state) // 2
    angles, omega = state[half - 3 : half], state[-3:]
    by_angle = twin.derivative(lambda a: twin.rotation(np.concatenate([np.zeros(2), a])).ravel(), angles)
    turns = twin.rotation(np.concatenate([np.zeros(2), angles])).T @ by_angle.T.reshape(3, 3, 3)
    axes = np.array([[turn[2, 1], turn[0, 2], turn[1, 0]] for turn in turns]).T
    after = state.copy()
    after[: half - 3] += dt * state[half:-3]
    after[half - 3 : half] += dt * np.linalg.solve(axes, omega)
    return after


def rows_of(jaw, state):
    """(12, n) derivative of the readings by the state, by the complex step."""
    return twin.derivative(lambda s: twin.measurement(jaw, s), state)
