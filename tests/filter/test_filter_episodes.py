"""The filter over whole episodes: its matrices stay sound, and its claims honest."""

import gymnasium as gym
import numpy as np
import pytest
from hostile_actions import EXCITATIONS

import jawenv
from agents import load_agent
from jawenv.metrics.calibration import covered, nees, nees_band
from jawenv.playing.rollout import play

ID = "jawenv/Jaw-v3"
GAIN = 22  # index of the load cell's gain error, the last state of the bound's recursion
PATIENTS = 48


def still(k):
    return np.zeros(4, dtype=np.float32)


def swinging(k):
    turn = 0.1 * np.sin(2 * np.pi * k / 100)
    return np.array([*[0.1 * np.cos(2 * np.pi * k / 160)] * 2, turn, -turn], dtype=np.float32)


def far_off():
    """A patient one of whose b lies five prior sds above the mean: 31."""
    prior = jawenv.cohort("trismus").prior
    theta = prior.mean.copy()
    theta[1] += 5.0 * prior.sd[1]
    return {"patient": jawenv.Patient.from_log_parameters(theta)}


def assert_covariance(P):
    """Symmetric to rounding, and the correlation matrix has a Cholesky factor."""
    sd = np.sqrt(np.diag(P))
    correlation = P / np.outer(sd, sd)
    np.testing.assert_allclose(correlation, correlation.T, rtol=0, atol=1e-9)
    np.linalg.cholesky(correlation)


@pytest.mark.parametrize(
    ("motion", "options", "reality", "seconds"),
    [
        (still, None, None, 300.0),
        (swinging, None, None, 300.0),
        (swinging, far_off(), None, 100.0),
        (swinging, None, {"lost_share": 0.2, "frozen_share": 0.2}, 100.0),
    ],
    ids=["still", "swinging", "five_sds_off", "faulty"],
)
def test_minutes_leave_the_covariances_symmetric_and_positive_definite(motion, options, reality, seconds):
    env = gym.make(ID, control="trajectory", episode_s=seconds, track_bound=True, reality=reality)
    env.reset(seed=5001, options=options)
    world, left_out, gated, steps = env.unwrapped.simulation.worlds[0], 0.0, 0.0, round(20 * seconds)
    belief = world["known"]["belief"]
    for k in range(steps):
        _, _, terminated, truncated, info = env.step(motion(k))
        assert not terminated
        left_out += info["left_out"] / steps
        gated += 5.0 * info["gated"]
        if k % 400 == 399:
            for P in (belief["cov"], belief["motion_cov"], world["truth"]["bound"][:GAIN, :GAIN]):
                assert_covariance(P)
            assert np.isfinite(belief["motion"]).all()
            assert (info["belief_sd"] < 1.05 * env.unwrapped.prior.sd).all()
    assert truncated
    assert gated == 0.0 if reality is None else gated <= 5.1
    # Of an encoder 0.4 less the repetitions of what was lost, 0.04; of a component of the load cell 0.4.
    assert left_out == pytest.approx(0.0 if reality is None else (12 * 0.36 + 6 * 0.4) / 18, abs=0.01)


MOVING = ("opening_with_swings_and_fore_aft", "opening_with_swings", "multisine", "slow_opening")


def agent_named(name, control):
    return EXCITATIONS[name] if name in EXCITATIONS else load_agent(name, control=control)


@pytest.mark.parametrize(
    ("name", "control"),
    [*((name, "force") for name in (*MOVING, "random", "ou_quick")), *((name, "trajectory") for name in MOVING)],
)
def test_what_the_filter_claims_is_so(name, control):
    """NEES/12 of 0.82 to 1.2, an honest filter's in all but a thousandth of such tests; coverage of one and two sds."""
    kwargs = {"control": control, "episode_s": 10.0, "track_bound": False}
    recording = play(agent_named(name, control), patients=PATIENTS, seed=6400, env_kwargs=kwargs)
    error = recording.at_end(recording.belief_mean) - recording.truth
    covariance, sd = recording.at_end(recording.belief_cov), recording.at_end(recording.belief_sd)
    low, high = nees_band(PATIENTS, 12, 0.999)
    mean = nees(error, covariance).mean()
    assert low < mean < high, mean / 12
    # Twelve errors of one patient are correlated; as if there were four of them, three sds of a share of 192.
    assert -0.1 < covered(error, sd, 1.0).mean() - 0.683 < 0.14
    assert covered(error, sd, 2.0).mean() == pytest.approx(0.954, abs=0.045)


def test_two_minutes_of_stretches_are_claimed_rightly():
    """Without a number of its own for what the gain error makes of inertia, 1.40: too sure of the gain."""
    kwargs = {"episode_s": 120.0, "track_bound": False}
    recording = play(load_agent("open_and_hold", control="targets"), patients=12, seed=6400, env_kwargs=kwargs)
    error = recording.at_end(recording.belief_mean) - recording.truth
    assert nees(error, recording.at_end(recording.belief_cov)).mean() / 12 < 1.2


def test_nobody_knows_more_than_the_bound_allows():
    agent = load_agent(MOVING[0], control="force")
    recording = play(agent, patients=16, seed=6400, env_kwargs={"episode_s": 10.0})
    bound, claimed = recording.information_bound[:, -1], recording.information_claimed[:, -1]
    assert bound.mean() > claimed.mean() - 1.0
    assert claimed.mean() > 20.0, "and it does learn"
    assert claimed.mean() - recording.information_true[:, -1].mean() < 3.0
