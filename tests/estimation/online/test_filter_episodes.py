"""The filter over whole episodes: its matrices stay sound, and its claims honest."""

import gymnasium as gym
import numpy as np
import pytest

import jawenv
from agents import load_agent
from jawenv.metrics.calibration import covered, nees
from jawenv.rollout import play

ID = "jawenv/Jaw-v0"
GAIN = 22  # index of the load cell's gain error, the last state of the bound's recursion


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
    """Symmetric to the bit, and the correlation matrix has a Cholesky factor."""
    np.testing.assert_array_equal(P, P.T)
    sd = np.sqrt(np.diag(P))
    np.linalg.cholesky(P / np.outer(sd, sd))


@pytest.mark.parametrize("motion", [still, swinging])
@pytest.mark.parametrize(
    ("options", "reality"),
    [(None, None), (far_off(), None), (None, {"lost_share": 0.2, "frozen_share": 0.2})],
    ids=["drawn", "five_sds_off", "faulty"],
)
def test_ten_minutes_leave_the_covariances_symmetric_and_positive_definite(motion, options, reality):
    env = gym.make(ID, control="trajectory", episode_s=600.0, track_bound=True, reality=reality)
    env.reset(seed=1, options=options)
    world, left_out = env.unwrapped.simulation.worlds[0], 0.0
    belief = world["belief"]
    for k in range(12_000):
        _, _, terminated, truncated, info = env.step(motion(k))
        assert not terminated
        left_out += info["left_out"] / 12_000
        if k % 1200 == 1199:
            for P in (belief["cov"], belief["motion_cov"], world["bound"][:GAIN, :GAIN]):
                assert_covariance(P)
            assert np.isfinite(belief["motion"]).all()
            assert (info["belief_sd"] < 1.05 * env.unwrapped.prior.sd).all()
    assert truncated
    # Of an encoder 0.4 less the repetitions of what was lost, 0.04; of a component of the load cell 0.4.
    assert left_out == pytest.approx(0.0 if reality is None else (12 * 0.36 + 6 * 0.4) / 18, abs=0.005)


# Measured with 48 patients: NEES 12.6 (force, 15 s) and 13.5 (trajectory, 8 s), 2-sigma coverage 0.95 and 0.94. An
# honest filter's mean NEES would be 12 with a standard error of 0.7; patients are truncated at 2 sd, which lowers it.
@pytest.mark.parametrize(("control", "episode_s"), [("force", 15.0), ("trajectory", 8.0)])
def test_what_the_filter_claims_is_so(control, episode_s):
    agent = load_agent("opening_with_swings_and_fore_aft", control=control)
    recording = play(agent, patients=48, seed=40_000, env_kwargs={"control": control, "episode_s": episode_s})
    error = recording.at_end(recording.belief_mean) - recording.truth
    covariance = recording.at_end(recording.belief_cov)
    sd = recording.at_end(recording.belief_sd)
    assert not recording.terminated.any()
    assert 7.5 < nees(error, covariance).mean() < 16.0
    assert 0.88 < covered(error, sd, 2.0).mean() < 0.995
    assert 0.55 < covered(error, sd, 1.0).mean() < 0.84
    bound, claimed = recording.information_bound[:, -1], recording.information_claimed[:, -1]
    assert bound.mean() > claimed.mean() - 1.0, "nobody knows more than the bound allows"
    assert claimed.mean() > 20.0, "and it does learn"
    gap = claimed.mean() - recording.information_true[:, -1].mean()
    assert abs(gap) < 3.0
