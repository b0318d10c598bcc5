"""What load-cell noise and servo put into the score: the kernels against matrices, the claims against many worlds."""

from dataclasses import replace

import gymnasium as gym
import newton_euler as twin
import numpy as np
import pytest
from recorded import recording
from running import Running, half_way, line_wrenches, to_coordinates

import jawenv
from agents.registry import load_agent
from jawenv.device.device import Device
from jawenv.envs.recording import record_of
from jawenv.estimation.noisy_input import LARGEST_TREMBLE, limit_tremble
from jawenv.estimation.numpy_model import step_with_derivative
from jawenv.estimation.online import TensionFilter
from jawenv.metrics import nees
from jawenv.rollout import play

CONTROLS = ["force", "trajectory"]


class Matrices:
    """C and M in NumPy, from the step's and the update's matrices: the recursions of ``noisy_input`` as written."""

    def __init__(self, running):
        self.running = running
        self.C, self.M = running.belief["motion_cov"].copy(), np.zeros((running.size, running.size))

    def predict(self, k):
        running, record, n = self.running, self.running.record, self.running.size
        before, P, old = running.belief["motion"].copy(), running.belief["motion_cov"].copy(), self.C
        running.predict(k)
        scratch, after = running.scratch, running.belief["motion"].copy()
        A, G = scratch["total"][:, :n].copy(), scratch["total"][:, n + 1 : n + 7].copy()
        N, W = np.diag(record.cell_sd**2), np.diag(record.wrench_sd**2)
        B, H, answer = A, G, scratch["answer"].copy()
        if answer.any():
            B, H = scratch["loop"][:, :n].copy(), scratch["loop"][:, n:].copy()
        self.C = B @ old @ A.T + H @ (W - N) @ G.T
        D = 0.5 * ((P - old) @ A.T + running.belief["motion_cov"] - self.C)
        self.score, self.information = np.zeros_like(running.belief["score"]), 0.0
        self.M *= min(1.0, n / max(np.sum(self.M * running.belief["motion_cov"]), 1e-30))
        MG = self.M @ G
        self.add_lines(MG.T @ D.T, before, after)
        if not answer.any():
            # The reading's noise n makes e = G n.
            taken = np.trace(MG @ N @ G.T)
            self.score[-1], self.information = taken, -taken
        self.M = A.T @ self.M @ A

    def add_lines(self, spilt, before, after):
        """``spilt`` times the derivative by pose, half way, of the wrench that the lines' generalised force is of."""
        running, jaw, n = self.running, self.running.record.jaw, self.running.size
        middle, nothing = 0.5 * (before + after), np.zeros(6)
        calm = running.belief["strain_mean"].copy(), running.scratch["kept"].copy()

        def forces(at):
            place, R = half_way(jaw, at, at)
            on = to_coordinates(jaw, at[: n // 2], R)
            return on @ line_wrenches(jaw, running.basis, place, R, nothing, *calm), on

        back = np.linalg.pinv(forces(middle)[1])
        for c in range(n // 2):
            step = 1e-6 * np.eye(n)[c]
            self.score += spilt[:, c] @ back @ (forces(middle + step)[0] - forces(middle - step)[0]) / 2e-6

    def update(self, k):
        running, record = self.running, self.running.record
        path, P = running.belief["motion"].copy(), running.belief["motion_cov"].copy()
        running.update(k)
        rows = twin.derivative(lambda s: twin.measurement(record.jaw, s), path)
        taken, rest = np.zeros_like(self.M), np.eye(len(P))
        for h, r in zip(rows, running.variances, strict=True):
            S = h @ P @ h + r
            of_one = np.eye(len(P)) - np.outer(P @ h, h) / S
            # What this reading takes of T = cov(by_tension, e) as it was before the tick's first reading.
            taken += rest.T @ np.outer(h, h) @ rest / S
            self.C, P, rest = self.C @ of_one.T, of_one @ P, of_one @ rest
        self.M = rest.T @ self.M @ rest + taken


@pytest.mark.parametrize(
    ("control", "device"),
    [("force", None), ("force", Device()), ("trajectory", Device(brake_N_s_m=0.0)), ("trajectory", Device())],
    ids=["nothing", "brake", "servos", "servos and brake"],
)
def test_the_kernels_are_the_recursions(control, device):
    """Along a fast jaw's record, 40 ticks: C and M to rounding; the score to what a step's turning does to a wrench."""
    record = replace(recording().records[0], device=device, control=control)
    running = Running(record)
    twins = Matrices(running)
    twins.update(0)
    P, answered = running.belief["motion_cov"], 0
    for k in range(40):
        score, information = running.belief["score"].copy(), running.belief["information"].copy()
        twins.predict(k)
        sd = np.sqrt(np.diag(P))
        C = running.belief["tremble"]
        np.testing.assert_allclose(C / np.outer(sd, sd), twins.C / np.outer(sd, sd), rtol=0, atol=1e-9)
        taken = running.belief["score"] - score
        size = np.abs(twins.score[:-1]).max()
        np.testing.assert_allclose(taken[:-1], twins.score[:-1], rtol=0, atol=0.02 * size + 1e-12)
        assert taken[-1] == pytest.approx(twins.score[-1], rel=1e-6)
        changed = running.belief["information"] - information
        assert changed[-1, -1] == pytest.approx(twins.information, rel=1e-6)
        changed[-1, -1] = 0.0
        np.testing.assert_array_equal(changed, 0.0)
        twins.update(k + 1)
        M = running.belief["aftermath"]
        np.testing.assert_allclose(M * np.outer(sd, sd), twins.M * np.outer(sd, sd), rtol=1e-8, atol=1e-10)
        answered += running.scratch["answer"].any()
    assert size > 0.0
    assert 20 < answered if device else answered == 0


def held_still(control, worlds, seconds, gain=0.0, record=False, device=None):
    """Many worlds of the prior's mean patient whose motors do nothing."""
    prior = jawenv.cohort("trismus").prior
    patient = jawenv.Patient.from_log_parameters(prior.mean)
    kwargs = {
        "control": control,
        "episode_s": seconds,
        "device": {"cell_gain": gain, **(device or {})},
        "record": record,
    }
    env = gym.make_vec("jawenv/Jaw-v0", num_envs=worlds, **kwargs)
    env.reset(seed=5, options={"patients": [patient] * worlds})
    return env


@pytest.mark.parametrize("control", CONTROLS)
def test_tremble_is_the_covariance_of_motion_and_error(control):
    """Over worlds that differ in noise alone, after 0.4 to 1 s, in standard errors of the worlds' scatter."""
    number = 300
    env = held_still(control, number, 1.0, gain=0.0)
    actions, worlds = np.zeros((number, 4), dtype=np.float32), env.unwrapped.simulation.worlds
    found, claimed, usual = [], [], []
    for step in range(19):
        env.step(actions)
        if step < 7:
            continue
        truth, error = worlds["state"], worlds["belief"]["motion"] - worlds["state"]
        away, wrong = truth - truth.mean(axis=0), error - error.mean(axis=0)
        found.append(-away[:, :, None] * wrong[:, None, :])
        claimed.append(worlds["belief"]["tremble"].mean(axis=0))
        usual.append(worlds["belief"]["motion_cov"].mean(axis=0))
    of_world = np.mean(found, axis=0)
    standard_error = of_world.std(axis=0, ddof=1) / np.sqrt(number)
    from_claim, from_usual = (
        (of_world.mean(axis=0) - np.mean(one, axis=0)) / standard_error for one in (claimed, usual)
    )
    assert np.mean(from_claim**2) < 2.0
    assert np.abs(from_claim).max() < 5.0
    assert np.sum(from_usual**2) > np.sum(from_claim**2) + 40.0, "uncorrelated with the estimate it is not"


def test_a_brake_meets_speeds_that_the_unmodelled_wrench_has_changed():
    """Their covariance from the independent step's derivative; what the load cell's noise does is not the truth's."""
    record = recording(cohort="healthy").records[0]
    running = Running(record).run(20)
    theta = running.belief["mode_mean"].copy()
    running.predict(20)
    start = np.concatenate([running.scratch["start_motion"], theta, [0.0]])
    _, by_all = step_with_derivative(record.jaw, start, record.samples[20], np.zeros(6), record.dt)
    by_wrench = by_all[5:10, -12:-6]
    expected = by_wrench * record.wrench_sd**2 @ by_wrench.T - by_wrench * record.cell_sd**2 @ by_wrench.T
    np.testing.assert_allclose(running.scratch["speeds_cov"], expected, rtol=1e-7, atol=1e-9 * expected.max())
    assert 2e-3 < np.sqrt(expected[0, 0]) < 0.05, "m/s"


def test_errors_of_a_jaw_on_its_teeth_are_as_large_as_claimed():
    """Under three times the load cell's noise; errors were up to half more when the noise passed for constant."""
    device = {"cell_force_N": 0.21, "cell_moment_N_m": 0.0042}
    env = held_still("force", 6, 12.0, record=True, device=device)
    for _ in range(239):
        env.step(np.zeros((6, 4), dtype=np.float32))
    shares = []
    for i in range(6):
        record = record_of(env.unwrapped.simulation, i)
        running = Running(record, record.truth)
        running.update(0)
        for k in range(len(record.samples)):
            running.predict(k)
            error = running.belief["motion"] - record.states[k + 1]
            if k >= 200:
                shares.append(error**2 / np.diag(running.belief["motion_cov"]))
            running.update(k + 1)
    assert np.abs(np.mean(shares, axis=0) - 1.0).max() < 0.12


# Of the mean patient 100 times, 20 s: 0.1 at most for the force (0.07 by chance), 0.2 for the servo; without the
# correction by F_o of the masseter +0.36 and +1.3, by b of the pterygoid 0.3 and -2.8.
@pytest.mark.parametrize(("control", "without"), [("force", 0.25), ("trajectory", 1.0)])
def test_the_belief_of_a_jaw_held_still_is_not_biased(control, without):
    """Mean error in sds, left and right together; the same records without the correction are off."""
    number, steps = 60, 400
    env = held_still(control, number, 20.0, gain=0.01, record=True)
    actions, simulation = np.zeros((number, 4), dtype=np.float32), env.unwrapped.simulation
    for _ in range(steps - 1):
        env.step(actions)
    belief, truth = simulation.worlds["belief"], simulation.worlds["log_parameters"]
    sd = np.sqrt(np.array([np.diag(cov) for cov in belief["cov"]]))
    share = (belief["mean"] - truth) / sd
    assert np.abs(share.reshape(number, 2, 6).mean(axis=(0, 1))).max() < 0.35
    moved = []
    for i in range(4):
        uncorrected = replace(record_of(simulation, i), cell_sd=np.zeros(6), control="force", device=None)
        moved.append((TensionFilter().estimate(uncorrected).mean[-1] - belief["mean"][i]) / sd[i])
    assert np.abs(np.mean(moved, axis=0)).max() > without


def test_an_estimate_trembles_no_more_than_straight_lines_can_say(rng):
    """|D_ii| <= sd of the estimate times sd of the error (Cauchy and Schwarz); a smaller D stays as it is."""
    factor = rng.normal(size=(12, 16))
    scale = np.repeat([3e-5, 1e-3, 1e-3, 1e-2], 3)
    P = factor @ factor.T * np.outer(scale, scale)
    D = 0.5 * P
    C = P - D
    limit_tremble(C, P)
    np.testing.assert_array_equal(C, P - D)
    D = -4e3 * P
    C = P - D
    limit_tremble(C, P)
    kept = (P - C) / D
    np.testing.assert_allclose(kept, kept[0, 0], rtol=1e-6)
    sd = np.abs(np.diag(P - C)) / np.sqrt(np.diag(P))
    most = sd[:6] / LARGEST_TREMBLE * np.repeat([1.0, 0.1], 3)  # m, and rad at an arm of 0.1 m
    assert most.max() == pytest.approx(1.0, rel=1e-6)


def test_a_jaw_that_falls_off_the_crest_is_not_misjudged():
    """The patient of seed 23 rides over it with the left condyle at 15 s: NEES/12 of 1,000 without the limit."""
    played = play(
        load_agent("opening_with_swings_and_fore_aft", env_id="jawenv/JawBilateral-v0"),
        patients=1,
        seed=23,
        env_id="jawenv/JawBilateral-v0",
        env_kwargs={"episode_s": 17.0, "track_bound": False},
    )
    assert nees(played.belief_mean[0, -1] - played.truth[0], played.belief_cov[0, -1]) / 12.0 < 4.0


def test_where_readings_are_lost_the_correction_stays_finite():
    """Half of them; measured without the limit: M a hundred thousand times P^-1 within 3 s."""
    record = recording().records[0]
    rng, running = np.random.default_rng(1), Running(record)
    running.update(0)
    for k in range(300):
        running.known = record.noise_variance
        running.known[:6] *= 90.0 if rng.random() < 0.4 else 1.0
        running.predict(k)
        running.update(k + 1, (rng.random(12) > 0.4).astype(np.uint8))
        told = np.sum(running.belief["aftermath"] * running.belief["motion_cov"])
        assert 0.0 <= told < 1e4
    assert np.isfinite(running.belief["score"]).all()
