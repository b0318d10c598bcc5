"""Teeth's steepness where an estimate trembles on them: against an independent jaw, and by what the filter learns."""

import gymnasium as gym
import newton_euler as twin
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import norm

import jawenv
from agents import load_agent
from jawenv.estimation.held_teeth import LARGEST_OFFSET, MEAN_OVER, follow_teeth, hold_teeth, mean_steepness
from jawenv.estimation.replay import online_scratch_dtype
from jawenv.estimation.sensitivity import rate_and_sensitivity
from jawenv.mechanics.jaw import build_jaw

POSE = np.array([1.5e-3, 0.0, -5.5e-3, 0.001, -0.001])  # all teeth on their onset
DT = 0.01
JAW = build_jaw()


def made():
    return np.zeros(1, dtype=online_scratch_dtype(6, 6, 10, 5))[0]


def depths(pose):
    """(3,) m, of each tooth, by the independent jaw."""
    q = np.asarray(pose)
    return twin.contact(JAW, q)[2] + (JAW["teeth"] @ twin.rotation(q).T)[:, 2] - JAW["teeth"][:, 2]


def on_average(depth, sd):
    """The ramp's slope over a normal depth (m): Gauss and Legendre's quadrature between its two kinks."""
    nodes, weights = np.polynomial.legendre.leggauss(80)
    kinks = np.clip((np.array([0.0, JAW["stop_width"]]) - depth) / sd, -9.0, 9.0)
    half = 0.5 * (kinks[1] - kinks[0])
    z = kinks[0] + half * (nodes + 1.0)
    within = half * weights @ (norm.pdf(z) * (depth + sd * z) / JAW["stop_width"])
    return within + norm.sf((JAW["stop_width"] - depth) / sd)


def rates_by_state(held, steepness, variance=0.0):
    """(10, 10) the derivative of the motion's rate at ``POSE`` with these teeth held."""
    scratch, tuples = made(), (tuple(POSE), (0.0,) * 5)
    scratch["stage"][:, :10] = np.eye(10)
    scratch["held"], scratch["steepness"], scratch["depth_variance"] = held, steepness, variance
    muscles = np.tile([1e-9, 1.0], (6, 1))
    rate_and_sensitivity(JAW, muscles, *tuples, (0.0,) * 6, np.zeros(6), 0.0, 0.0, scratch)
    hold_teeth(JAW, tuples[0], scratch)
    return scratch["slope"][:, :10].copy()


def test_a_held_tooth_is_a_spring_of_the_steepness_at_which_it_is_held():
    """Against the independent jaw that a linear spring at each tooth pushes more than its onset does."""
    held, steepness = np.array([1, 0, 1]), np.array([0.9, 0.9, 0.05])
    at, R = depths(POSE), twin.rotation(POSE)
    assert (0.0 < at).all() and (at < JAW["stop_width"]).all()
    more = held * (at / JAW["stop_width"] - steepness)

    def acceleration(q):
        force = JAW["tooth_stiffness"] * more * (depths(q) - at)
        up = R.T @ [0.0, 0.0, 1.0]
        moments = np.cross(JAW["teeth"] - JAW["mouthpiece"], up)
        wrench = np.concatenate([force.sum() * up, force @ moments])
        return twin.acceleration(JAW, np.log(np.tile([1e-9, 1.0], 6)), q, np.zeros(5), wrench)

    steps = 1e-7 * np.eye(5)
    expected = np.array([(acceleration(POSE + s) - acceleration(POSE - s)) / 2e-7 for s in steps]).T
    found, plain = rates_by_state(held, steepness), rates_by_state(0, steepness)
    np.testing.assert_allclose(found[5:, :5], expected, rtol=1e-5, atol=1e-6 * np.abs(expected).max())
    assert np.abs(found - plain)[5:, :5].max() > 0.1 * np.abs(plain).max()
    np.testing.assert_array_equal(found[:, 5:], plain[:, 5:])
    np.testing.assert_allclose(rates_by_state(held, at / JAW["stop_width"]), plain, rtol=1e-9, atol=1e-6)


def test_another_tooth_is_as_steep_as_on_average_over_the_depths_that_may_be_true():
    sd = np.array([5e-5, 2e-4, 4e-4])
    found = rates_by_state(0, 0.0, sd**2)
    expected = rates_by_state(1, [on_average(*one) for one in zip(depths(POSE), sd, strict=True)])
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
    assert np.abs(found - rates_by_state(0, 0.0)).max() > 0.02 * np.abs(expected).max()


@settings(deadline=None)  # the first call compiles
@given(depth=st.floats(-3e-3, 3e-3), sd=st.floats(2e-5, 2e-3))
def test_the_mean_steepness_is_that_of_the_ramp(depth, sd):
    width = JAW["stop_width"]
    found = mean_steepness(depth, sd**2, width)
    assert np.isclose(found, on_average(depth, sd), rtol=1e-9, atol=1e-8)
    assert mean_steepness(depth, 0.0, width) == np.clip(depth / width, 0.0, 1.0)
    assert mean_steepness(depth, -1e-20, width) == np.clip(depth / width, 0.0, 1.0), "a variance's rounding"


def follow(pose, means, sd):
    """Held teeth and their steepness after a tick at ``pose`` of an opening angle known to ``sd`` (rad)."""
    scratch, motion, covariance = made(), np.concatenate([pose, np.zeros(5)]), np.zeros((10, 10))
    covariance[2, 2] = sd**2
    follow_teeth(JAW, motion, covariance, means, DT, scratch)
    return scratch["held"].astype(bool), scratch["steepness"].copy()


@settings(deadline=None)  # the first call compiles
@given(offset=st.floats(-6.0, 6.0), sd=st.floats(1e-5, 1e-3))
def test_a_tooth_is_held_while_its_depth_may_be_the_mean(offset, sd):
    """The mean goes a tenth of the way each tick; a jaw that has truly moved takes it along."""
    means = depths(POSE)
    old, turned = means.copy(), POSE + [0.0, 0.0, offset * sd, 0.0, 0.0]
    held, steepness = follow(turned, means, sd)
    near = np.abs(offset) < 0.98 * LARGEST_OFFSET
    if near or np.abs(offset) > 1.02 * LARGEST_OFFSET:
        assert (held == near).all()
    share = np.where(held, DT / MEAN_OVER, 1.0)
    np.testing.assert_allclose(means, old + share * (depths(turned) - old), rtol=1e-9, atol=1e-15)
    step = [0.0, 0.0, 1e-6, 0.0, 0.0]
    depth_sd = np.abs(depths(turned + step) - depths(turned - step)) / 2e-6 * sd
    expected = np.array([on_average(*one) for one in zip(means, depth_sd, strict=True)])
    np.testing.assert_allclose(steepness[held], expected[held], rtol=1e-6, atol=1e-8)


def test_the_first_depth_is_its_own_mean():
    means = np.full(3, np.nan)
    held, _ = follow(POSE, means, 1e-4)
    assert not held.any()
    np.testing.assert_allclose(means, depths(POSE), rtol=1e-9)


def test_a_jaw_that_a_servo_holds_on_its_teeth_is_learned_honestly():
    """Twelve times one patient, 20 s: a mean NEES/12 of 0.5; with the steepness at the estimate it was 2.5."""
    number, seconds = 12, 20.0
    short = jawenv.play(
        load_agent("hold_still"), patients=24, seed=10_000, env_kwargs={"record": True, "episode_s": 0.1}
    )
    patient = jawenv.Patient.from_log_parameters(short.records[23].truth)
    env = gym.make_vec("jawenv/Jaw-v0", num_envs=number, control="trajectory", episode_s=seconds)
    env.reset(seed=7, options={"patients": [patient] * number})
    for _ in range(round(20 * seconds) - 1):
        _, _, _, _, info = env.step(np.zeros((number, 4), dtype=np.float32))
    assert (depths(np.median(info["jaw_state"], axis=0)[:5]) > 0.0).any()
    assert np.mean(info["nees"] / 12.0) < 1.0
