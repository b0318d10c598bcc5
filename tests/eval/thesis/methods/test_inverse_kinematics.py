"""Motion from the mouthpiece's pose and its rates, against the independent model."""

import newton_euler as twin
import numpy as np

from eval.thesis.methods.inverse_kinematics import acceleration_from_mouthpiece, motion_from_pose
from jawenv.mechanics import build_jaw

SD = np.repeat([1e-4, 1.7e-3, 1e-3, 2e-2], 3)
FREE = np.ones(10)
LOW = np.array([5e-4, -3e-3, 0.0, -0.1, -0.1, -0.03, -0.03, -1.0, -1.0, -1.0])
HIGH = np.array([1.2e-2, 3e-3, 0.4, 0.1, 0.1, 0.03, 0.03, 1.0, 1.0, 1.0])


def readings(jaw, states):
    return np.array([twin.measurement(jaw, state) for state in states])


def test_without_noise_the_motion_is_recovered_to_rounding(jaw, rng):
    states = rng.uniform(LOW, HIGH, (50, 10))
    found = motion_from_pose(jaw, readings(jaw, states), SD, np.zeros(10), FREE)
    np.testing.assert_allclose(found, states, atol=1e-12)


def test_what_cannot_move_stays(rng):
    jaw = build_jaw(free=(True, False, True, False, False))
    moves = np.array([1, 0, 1, 0, 0, 1, 0, 0, 1, 0], dtype=bool)
    states = np.where(moves, rng.uniform(LOW, HIGH, (20, 10)), 0.0)
    noisy = readings(jaw, states) + SD * rng.standard_normal((20, 12))
    found = motion_from_pose(jaw, noisy, SD, np.zeros(10), moves.astype(float))
    assert (found[:, ~moves] == 0.0).all()
    rows = twin.derivative(lambda s: twin.measurement(jaw, s), states[0])[:, moves] / SD[:, None]
    sd = np.sqrt(np.diag(np.linalg.inv(rows.T @ rows)))
    assert (np.abs(found - states)[:, moves] < 6.0 * sd).all()


def test_accelerations_are_those_of_the_independent_model(jaw, rng):
    states = rng.uniform(LOW, HIGH, (20, 10))
    rates = np.array([twin.state_rate(jaw, np.tile([1.0, 1.8], 6), s, rng.normal(size=6)).real for s in states])
    of_mouthpiece = [
        (twin.derivative(lambda s: twin.measurement(jaw, s), state) @ rate)[6:]
        for state, rate in zip(states, rates, strict=True)
    ]
    found = acceleration_from_mouthpiece(jaw, states, np.array(of_mouthpiece), SD[6:], np.ones(5, dtype=bool))
    np.testing.assert_allclose(found, rates[:, 5:], atol=1e-8 * np.abs(rates).max())
