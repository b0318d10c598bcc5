"""What teeth and stops push on average over an uncertain motion: against drawn motions, and by the filter's errors."""

import newton_euler as twin
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from running import Running
from scipy.integrate import quad
from scipy.stats import norm

import jawenv
from agents import load_agent
from jawenv.estimation.contact_mean import be_unsure, mean_excess, mean_push
from jawenv.estimation.replay import online_scratch_dtype
from jawenv.mechanics.jaw import build_jaw

SD = np.array([2e-5, 2e-5, 3e-4, 3e-4, 3e-4, 1e-3, 1e-3, 2e-2, 2e-2, 2e-2])
NO_MUSCLES = np.log(np.tile([1e-9, 1.0], 6))
# Teeth on their onset; condyles on that of the fossa's back, teeth apart; both apart.
POSES = {
    "teeth": (1.5e-3, 0.0, -5.5e-3, 0.001, -0.001),
    "fossa": (-2.5e-4, 0.0, 0.1, 0.0, 0.0),
    "apart": (4e-3, 0.0, 0.1, 0.0, 0.0),
}


@pytest.fixture(scope="module")
def jaw():
    return build_jaw()


@pytest.fixture
def scratch():
    made = np.zeros(1, dtype=online_scratch_dtype(6, 6, 10, 5))[0]
    made["stage"][:, :10] = np.eye(10)
    return made


def push_over(jaw, scratch, pose, covariance, tremble=None, noise=None):
    """(6,) mean push at ``pose``; by default the estimate is not correlated with its error."""
    noise = np.zeros(12) if noise is None else noise
    be_unsure(covariance, covariance if tremble is None else tremble, noise, scratch)
    return np.concatenate(mean_push(jaw, POSES[pose], scratch))


# At the fossa's back a sixth is due to its slope, which changes as the condyles slide, and is left out.
@pytest.mark.parametrize(("pose", "share"), [("teeth", 0.03), ("fossa", 0.2)])
def test_push_is_what_the_contacts_do_on_average_over_drawn_motions(jaw, scratch, pose, share):
    found = push_over(jaw, scratch, pose, np.diag(SD**2))
    draws = np.random.default_rng(0).normal(size=(100_000, 5)) * SD[:5]
    q, still, nothing = np.array(POSES[pose]), np.zeros(5), np.zeros(6)
    at = twin.acceleration(jaw, NO_MUSCLES, q, still, nothing)
    # In pairs, without what is odd in the draw.
    both = [twin.acceleration(jaw, NO_MUSCLES, q + side * draws, still, nothing).mean(axis=0) for side in (1, -1)]
    expected = 0.5 * (both[0] + both[1]) - at
    answer = twin.acceleration(jaw, NO_MUSCLES, q, still, found) - at
    assert np.abs(answer).max() > 0.1
    assert np.allclose(answer, expected, atol=share * np.abs(expected).max())


def test_apart_nothing_pushes(jaw, scratch):
    assert not push_over(jaw, scratch, "apart", np.diag(SD**2)).any()


def test_an_error_that_estimate_and_truth_share_pushes_the_other_way(jaw, scratch):
    """D = P: the estimate trembles, the truth does not. P - 2 D is -P."""
    covariance = np.diag(SD**2)
    optimal = push_over(jaw, scratch, "teeth", covariance)
    assert optimal[2] < 0.0
    assert np.allclose(push_over(jaw, scratch, "teeth", covariance, tremble=np.zeros((10, 10))), -optimal)
    assert np.allclose(push_over(jaw, scratch, "teeth", covariance, tremble=0.5 * covariance), 0.0, atol=1e-12)


def test_noise_within_the_step_counts_as_the_motion_that_it_makes(jaw, scratch):
    made = np.random.default_rng(1).normal(size=(10, 12)) * SD[:, None]
    unmodelled, cell = np.array([1.0, 2.0, 0.5, 1.5, 1.0, 2.0]), np.array([0.2, 0.1, 0.3, 0.1, 0.2, 0.1])
    scratch["stage"][:, -12:] = made
    found = push_over(jaw, scratch, "teeth", np.zeros((10, 10)), noise=np.r_[unmodelled + cell, cell])
    scratch["stage"][:, -12:] = 0.0
    total = (made * np.r_[unmodelled + cell, cell]) @ made.T
    true = (made[:, :6] * unmodelled) @ made[:, :6].T  # C: what moves the truth
    assert np.allclose(found, push_over(jaw, scratch, "teeth", total, tremble=true))


@settings(deadline=None)  # the first call compiles
@given(depth=st.floats(-1.0, 2.0), sd=st.floats(0.01, 0.2))
def test_mean_of_the_ramp(depth, sd):
    """Between its ends to a percent, beyond them by less than what the ramp gains in one sd."""
    width = 5e-4
    made = np.zeros(1, dtype=online_scratch_dtype(6, 6, 10, 5))[0]
    made["depth_row"][0] = 1.0
    made["start_cov"][0, 0] = made["start_spread"][0, 0] = (sd * width) ** 2
    found = mean_excess(depth * width, width, made) / width
    above, _ = quad(
        lambda z: twin.ramp(depth + sd * z, 1.0) * norm.pdf(z), -8, 8, points=[-depth / sd, (1 - depth) / sd]
    )
    exact = above - twin.ramp(depth, 1.0)
    inside = 3 * sd < depth < 1 - 3 * sd
    assert found == pytest.approx(exact, abs=(0.01 if inside else 0.35) * 0.5 * sd**2)


def test_where_the_pose_is_open_the_contacts_are_taken_as_they_are(jaw, scratch):
    assert push_over(jaw, scratch, "teeth", np.diag(SD**2)).any()
    assert not push_over(jaw, scratch, "teeth", np.diag((30.0 * SD) ** 2)).any()


def test_a_jaw_that_trembles_on_its_teeth_is_estimated_without_bias():
    """The belief is held at the truth. Without the mean push the opening angle is half an sd off in each of these."""
    device = {
        "unmodelled_force_N": 0.3,
        "unmodelled_moment_N_m": 0.009,
        "cell_force_N": 0.007,
        "cell_moment_N_m": 0.00014,
        "cell_gain": 1e-5,
        "brake_N_s_m": 0.0,
    }
    env = {"record": True, "episode_s": 10.0, "device": device}
    offsets = []
    for record in jawenv.play(load_agent("hold_still"), patients=4, seed=10020, env_kwargs=env).records:
        running = Running(record, record.truth.copy())
        running.update(0)
        errors = []
        for k in range(len(record.samples)):
            running.predict(k)
            running.update(k + 1)
            error = running.belief["motion"][2] - record.states[k + 1, 2]
            errors.append(error / np.sqrt(running.belief["motion_cov"][2, 2]))
        offsets.append(np.mean(errors[100:]))
    assert abs(np.mean(offsets)) < 0.3
