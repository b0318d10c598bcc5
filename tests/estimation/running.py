"""The environments' filter along a record, step by step, and what its kernels compute in plain NumPy."""

from dataclasses import replace

import newton_euler as twin
import numpy as np
import two_condyles
from jawenv.estimation.online.replay import online_scratch_dtype

from jawenv.estimation.model.encoders import expect
from jawenv.estimation.model.load_cell import follow_trend
from jawenv.estimation.online.basis import build_basis, nodes_needed
from jawenv.estimation.online.state import begin_belief, belief_dtype
from jawenv.estimation.online.time_update import predict_motion, update_motion


class Running:
    """The filter's motion and information along a record, at a belief that stays ``log_parameters``."""

    def __init__(self, record, log_parameters=None):
        self.record = record
        self.size, muscles = len(record.start_mean), len(record.parameter_names) // 2
        nodes = nodes_needed(record.prior)
        self.basis = build_basis(record.jaw, record.prior, nodes)[0]
        self.belief = np.zeros(1, dtype=belief_dtype(muscles, len(record.jaw["l_o"]), self.size, nodes))[0]
        dtype = online_scratch_dtype(muscles, len(record.jaw["l_o"]), self.size, nodes)
        self.scratch = np.zeros(1, dtype=dtype)[0]
        self.belief["motion"], self.belief["motion_cov"] = record.start_mean, np.diag(record.start_sd**2)
        theta = record.prior.mean.copy() if log_parameters is None else log_parameters
        begin_belief(self.basis, self.belief, theta, record.prior.sd.copy())
        self.variances, self.known = record.measurement_sd**2, record.noise_variance
        self.device, has_servo = record.answering()
        self.has_servo = np.uint8(has_servo)

    def predict(self, k):
        record = self.record
        predict_motion(
            record.jaw, self.belief, record.samples[k], record.dt, self.known, self.known, self.device,
            self.has_servo, self.scratch,
        )  # fmt: skip
        follow_trend(self.belief["trend"], record.samples[k], record.dt)

    def update(self, k, used=None):
        used = np.ones(12, dtype=np.uint8) if used is None else used
        update_motion(self.record.jaw, self.belief, self.record.measured[k], self.variances, used, self.scratch)

    def foresee(self, ticks):
        """The record with readings that this filter expects to the last bit: without innovations."""
        measured = self.record.measured.copy()
        self.record = replace(self.record, measured=measured)
        for k in range(ticks + 1):
            if k > 0:
                self.predict(k - 1)
            expect(self.record.jaw, self.belief["motion"], self.scratch["rows"], measured[k])
            self.update(k)
        return self.record

    def run(self, ticks):
        self.update(0)
        for k in range(ticks):
            self.predict(k)
            self.update(k + 1)
        return self

    @property
    def information(self):
        """The whole matrix, of which the filter keeps the lower half."""
        lower = np.tril(self.belief["information"])
        return lower + np.tril(lower, -1).T


def line_wrenches(jaw, basis, place, R, reading, means=0.0, kept=1.0):
    """(6, mK + 1) at the mouthpiece, body axes, of unit coefficients and of the gain error.

    ``kept`` is the share of each line's change of strain from its mean in ``means`` that is left.
    """
    n, K = basis["nodes"].shape
    wrenches = np.zeros((6, n * K + 1))
    for line in range(len(jaw["l_o"])):
        insertion = place + R @ jaw["insertion"][line]
        reach, muscle = jaw["origin"][line] - insertion, jaw["muscle"][line]
        strain = np.linalg.norm(reach) / jaw["l_o"][line] - 1.0
        mean, share = (np.broadcast_to(one, len(jaw["l_o"]))[line] for one in (means, kept))
        strain = mean + share * (strain - mean) - basis["centre"][muscle]
        force = reach / np.linalg.norm(reach)
        moment = np.cross(insertion - (place + R @ jaw["mouthpiece"]), force)
        wrench = np.concatenate([R.T @ force, R.T @ moment])
        for k in range(K):
            wrenches[:, muscle * K + k] += np.exp(basis["nodes"][muscle, k] * strain) * wrench
    wrenches[:, -1] = reading
    return wrenches


def half_way(jaw, before, after):
    q = 0.5 * (before + after)
    if len(q) == 12:
        return q[:3], twin.rotation(two_condyles.five(q[:6]))
    return twin.contact(jaw, q[:5]), twin.rotation(q[:5])


def to_coordinates(jaw, q, R):
    """(n / 2, 6): what the coordinates' generalised forces are of a wrench at the mouthpiece, body axes.

    The angles' are moments about the condyles, body axes.
    """
    slides = np.eye(3) if len(q) == 6 else np.array([[1.0, 0.0, twin.fossa(jaw, q[0])[1]], [0.0, 1.0, 0.0]])
    turns = np.array([np.cross(jaw["mouthpiece"], axis) for axis in np.eye(3)]).T
    return np.block([[slides @ R, np.zeros((len(slides), 3))], [turns, np.eye(3)]])
