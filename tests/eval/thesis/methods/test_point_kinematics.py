"""One measured point leaves two directions of pose open, and bounds do not close them."""

import newton_euler as twin
import numpy as np
from scipy.optimize import least_squares

from eval.thesis.methods.point_kinematics import compatible_range, mouthpiece

LOW = np.array([0.0, -3e-3, 0.0, -0.1, -0.1])
HIGH = np.array([1.2e-2, 3e-3, 0.45, 0.1, 0.1])
WIDTH = HIGH - LOW


def place(jaw, q):
    return twin.measurement(jaw, np.concatenate([q, np.zeros(5)]))[:3]


def test_the_jacobian(jaw, rng):
    q = rng.uniform(LOW, HIGH)
    reached, rows = mouthpiece(jaw, q)
    np.testing.assert_allclose(reached, place(jaw, q), atol=1e-14)
    np.testing.assert_allclose(rows, twin.derivative(lambda q: place(jaw, q), q), atol=1e-12)


def test_the_range_that_bounds_leave_is_wide_and_its_ends_are_reached(jaw):
    """An opening of 11 degrees: roll is anything, and lateral slide and yaw trade for each other to a bound."""
    q = np.array([5e-3, 5e-4, 0.2, 0.02, 0.01])
    extremes = compatible_range(jaw, q, LOW, HIGH)
    assert (extremes[:, 0] <= q + 1e-9).all() and (extremes[:, 1] >= q - 1e-9).all()
    share = (extremes[:, 1] - extremes[:, 0]) / WIDTH
    assert share[1] > 0.6 and share[3] > 0.2 and share[4] > 0.99
    # No pose that a search within the bounds finds lies outside.
    rng, target, poses = np.random.default_rng(5), place(jaw, q), []
    for start in rng.uniform(LOW, HIGH, (40, 5)):
        search = least_squares(
            lambda pose: 1e3 * (place(jaw, pose) - target), start, bounds=(LOW, HIGH), x_scale=WIDTH, xtol=1e-14
        )
        if np.abs(search.fun).max() < 1e-6:
            poses.append(search.x)
    assert len(poses) > 5
    assert (poses >= extremes[:, 0] - 1e-4 * WIDTH).all() and (poses <= extremes[:, 1] + 1e-4 * WIDTH).all()
    assert np.ptp(np.array(poses)[:, 1]) > 1e-3, "what is found depends on the start"
