"""The measurement update against textbook formulas, against filterpy, and the gate before it."""

from functools import cache

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from recorded import recording
from running import Running, rows_of

from jawenv.anatomy import cohort
from jawenv.filter.belief.state import begin_belief, belief_dtype
from jawenv.filter.model.basis import build_basis, set_derivatives
from jawenv.filter.updates.measurement_update import (
    EXPECTED,
    GATE,
    REFUSED,
    SURPRISING,
    add_information,
    correct_motion,
    judge_innovation,
    normalised_innovation,
    update_scratch_dtype,
)
from jawenv.mechanics import build_jaw

N, START_SD = 10, np.linspace(0.5, 1.5, 10)
CARRIED = ("motion", "motion_cov", "by_tension", "information", "score")
PRIOR = cohort("trismus").prior
any_seed = st.integers(0, 10_000)
quick = settings(max_examples=40, deadline=None, derandomize=True, database=None)


@cache
def basis():
    return build_basis(build_jaw(), PRIOR)[0]


class Linear:
    """A linear problem of the update's size: rows, variances, and what the filter carries, all drawn."""

    def __init__(self, seed, by_tension=1e-3):
        self.rng = rng = np.random.default_rng(seed)
        self.belief = np.zeros(1, dtype=belief_dtype(6, N))[0]
        begin_belief(basis(), self.belief, PRIOR.mean.copy(), PRIOR.sd.copy())
        root = rng.normal(size=(N, 2 * N)) * 10.0 ** rng.uniform(-2.0, 0.0, N)[:, None]
        self.belief["motion"], self.belief["motion_cov"] = rng.normal(size=N), root @ root.T
        self.belief["by_tension"][:, :31] = by_tension * rng.normal(size=(N, 31))
        self.scratch = np.zeros(1, dtype=update_scratch_dtype(6, 6, N))[0]
        self.rows, self.variance = rng.normal(size=(12, N)), 10.0 ** rng.uniform(-3.0, 0.0, 12)
        self.start = self.belief.copy()

    @property
    def S(self):
        return self.rows @ self.start["motion_cov"] @ self.rows.T + np.diag(self.variance)

    def honest(self):
        """An innovation as the filter expects them."""
        return np.linalg.cholesky(self.S) @ self.rng.normal(size=12)

    def nis(self, innovation):
        return innovation @ np.linalg.solve(self.S, innovation)

    def gate(self, innovation):
        scratch = self.scratch
        scratch["rows"], scratch["variance"], scratch["innovation"] = self.rows, self.variance, innovation
        scratch["by_tension_rows"] = self.rows @ self.belief["by_tension"]
        return judge_innovation(self.belief, START_SD, self.scratch)

    def update(self, innovation):
        verdict = self.gate(innovation)
        correct_motion(self.belief, self.scratch)
        if verdict != REFUSED:
            add_information(self.belief, 1.0, self.scratch)
        return verdict


def agree(actual, expected, tolerance=1e-9):
    """Each part relative to its own largest number, or to its sds."""
    for name in CARRIED:
        scale, found, wanted = np.abs(expected[name]).max(), actual[name], expected[name]
        if name == "information":  # its upper half alone is kept between two updates of the belief
            found, wanted = np.triu(found), np.triu(wanted)
        if name == "motion_cov":
            sd = np.sqrt(np.diag(expected[name]))
            scale = np.outer(sd, sd)
        assert (np.abs(found - wanted) <= tolerance * scale).all(), name


def textbook(belief, rows, variance, innovation):
    """Joseph's form and the inverse of S; V is the motion's derivative by the tensions."""
    P, V, R = belief["motion_cov"], belief["by_tension"], np.diag(variance)
    inverse = np.linalg.inv(rows @ P @ rows.T + R)
    K = P @ rows.T @ inverse
    rest, C = np.eye(len(P)) - K @ rows, rows @ V
    return {
        "motion": belief["motion"] + K @ innovation,
        "motion_cov": rest @ P @ rest.T + K @ R @ K.T,
        "by_tension": rest @ V,
        "information": belief["information"] + C.T @ inverse @ C,
        "score": belief["score"] + C.T @ inverse @ innovation,
    }


@quick
@given(seed=any_seed)
def test_a_linear_update_is_the_textbooks(seed):
    linear = Linear(seed)
    innovation = linear.honest()
    assert linear.update(innovation) == EXPECTED
    agree(linear.belief, textbook(linear.start, linear.rows, linear.variance, innovation))


def test_no_reading_at_all_changes_nothing():
    running = Running(recording().records[0]).run(30)
    running.predict(30)
    before = running.belief.copy()
    assert running.take(np.full(12, np.nan), np.zeros(12, dtype=np.uint8)) == EXPECTED
    for name in CARRIED:
        np.testing.assert_array_equal(running.belief[name], before[name])


def test_motion_and_covariance_are_those_of_filterpy(rng):
    """Sixty ticks with holes: filterpy's filter of the system that is linearised along the way."""
    running = Running(recording().records[0])
    record, belief, n = running.record, running.belief, running.size
    textbooks = KalmanFilter(dim_x=n, dim_z=12)
    textbooks.P = belief["motion_cov"].copy()
    for k in range(61):
        before = belief["motion"].copy()
        if k > 0:
            running.predict(k - 1)
            A, G = np.split(running.scratch["time"]["step"]["total"], [n], axis=1)
            off = A @ (textbooks.x[:, 0] - before)  # from the filter's own motion, which the model moves
            textbooks.predict(F=A, Q=G @ np.diag(record.noise_variance[:6]) @ G.T)
            textbooks.x = (belief["motion"] + off)[:, None]
        else:
            textbooks.x = before[:, None]
        chosen = rng.random(12) > 0.3
        H, path = rows_of(record.jaw, belief["predicted"])[chosen], belief["motion"].copy()
        z = (record.measured[k] - running.expected())[chosen] + H @ path
        textbooks.update(z[:, None], R=np.diag(running.settings["measurement_variance"][chosen]), H=H)
        running.update(k, chosen.astype(np.uint8))
        sd = np.sqrt(np.diag(textbooks.P))
        assert (np.abs(belief["motion"] - textbooks.x[:, 0]) < 1e-6 * sd).all()
        np.testing.assert_allclose(
            belief["motion_cov"] / np.outer(sd, sd), textbooks.P / np.outer(sd, sd), rtol=0, atol=1e-7
        )


@quick
@given(seed=any_seed, excess=st.floats(0.05, 20.0))
def test_a_reading_that_nothing_explains_is_refused(seed, excess):
    """It says nothing of the muscles; the motion's covariance is as many times as wide as the innovation is long."""
    linear = Linear(seed, by_tension=0.0)
    innovation = linear.honest()
    innovation *= np.sqrt(GATE * (1.0 + excess) / linear.nis(innovation))
    nis = linear.nis(innovation)
    assert linear.gate(innovation) == REFUSED
    np.testing.assert_allclose(linear.belief["motion_cov"], linear.start["motion_cov"] * nis / 12.0, rtol=1e-9)
    widened = normalised_innovation(linear.belief, linear.scratch)
    assert widened < nis
    linear = Linear(seed, by_tension=0.0)
    linear.update(innovation)
    for name in ("information", "score"):
        np.testing.assert_array_equal(linear.belief[name], linear.start[name])
    assert np.isfinite(linear.belief["motion"]).all()
    assert np.linalg.eigvalsh(linear.belief["motion_cov"]).min() > 0.0


@quick
@given(seed=any_seed)
def test_an_innovation_that_the_muscles_explain_passes(seed):
    """The belief is wrong by two prior sds, and readings depend on it so much that the gate alone would refuse them."""
    linear = Linear(seed, by_tension=1.0)
    by_log = np.empty((linear.belief["by_tension"].shape[1], 12))
    set_derivatives(linear.belief["basis"], linear.belief["mean"], by_log)
    C = linear.rows @ linear.belief["by_tension"] @ by_log
    innovation = linear.honest() + C @ (2.0 * PRIOR.sd * linear.rng.choice([-1.0, 1.0], 12))
    whole = linear.S + C @ np.diag(PRIOR.sd**2) @ C.T
    assume(linear.nis(innovation) > GATE > innovation @ np.linalg.solve(whole, innovation))
    assert linear.update(innovation) == SURPRISING
    agree(linear.belief, textbook(linear.start, linear.rows, linear.variance, innovation), 1e-8)


@quick
@given(seed=any_seed, share=st.floats(0.0, 1.0))
def test_the_gate_is_at_the_stated_length(seed, share):
    linear = Linear(seed, by_tension=0.0)
    innovation = linear.honest()
    wanted = GATE * (0.5 + share)
    innovation *= np.sqrt(wanted / linear.nis(innovation))
    if abs(wanted / GATE - 1.0) > 1e-9:
        assert linear.gate(innovation) == (EXPECTED if wanted < GATE else REFUSED)


@pytest.mark.parametrize("broken", ["negative", "nan", "inf"])
def test_a_covariance_that_is_none_is_forgotten(broken):
    """The motion is known as at the start, whatever the muscles; the readings then correct it."""
    linear = Linear(5000)
    bad = {"negative": -np.eye(N), "nan": np.full((N, N), np.nan), "inf": np.full((N, N), np.inf)}[broken]
    linear.belief["motion_cov"] = bad
    innovation = linear.rng.normal(size=12)
    assert linear.update(innovation) == REFUSED
    known = linear.start.copy()
    known["motion_cov"], known["by_tension"] = np.diag(START_SD**2), 0.0
    expected = textbook(known, linear.rows, linear.variance, innovation)
    agree(linear.belief, expected)
    np.testing.assert_array_equal(linear.belief["by_tension"], 0.0)


@pytest.mark.parametrize("size", [1e3, 1e100, 1e200])
def test_a_reading_of_any_size_leaves_numbers(size):
    """The square of the largest is no number."""
    linear = Linear(5001)
    assert linear.update(size * linear.honest()) == REFUSED
    for name in CARRIED:
        assert np.isfinite(linear.belief[name]).all()
    assert np.linalg.eigvalsh(linear.belief["motion_cov"]).min() > 0.0
