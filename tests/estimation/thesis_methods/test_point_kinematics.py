"""One measured point leaves two directions of pose open, and bounds do not close them."""

import newton_euler as twin
import numpy as np
import pytest

from jawenv.errors import InputError
from jawenv.estimation.thesis_methods.point_kinematics import (
    compatible_range,
    mouthpiece,
    nearest_poses,
    null_directions,
)

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


def test_every_pose_found_has_the_point_in_its_place_and_none_on_the_surface_is_nearer(jaw, rng):
    start = np.array([4e-3, 0.0, 0.15, 0.0, 0.0])
    share = np.linspace(0.0, 1.0, 15)[:, None]
    true = start + share * [4e-3, 1e-3, 0.15, 0.03, 0.02]
    points = np.array([place(jaw, q) for q in true])
    poses, misses = nearest_poses(jaw, points, LOW, HIGH, start)
    assert misses.max() < 1e-9
    assert ((poses >= LOW) & (poses <= HIGH)).all()
    before = np.vstack([start, poses[:-1]])
    way = (poses - before) / WIDTH
    assert (np.linalg.norm(way, axis=1) <= np.linalg.norm((true - before) / WIDTH, axis=1) + 1e-9).all()
    for pose, step in zip(poses, way, strict=True):
        directions, _ = null_directions(jaw, pose, WIDTH)
        assert np.abs((directions / WIDTH) @ step).max() < 1e-5 * max(np.linalg.norm(step), 1e-3), (
            "normal to the surface"
        )


def test_what_is_found_depends_on_where_the_search_began(jaw):
    """Not unique within bounds: the same path of the point, two starts, condyles 1 mm apart and no miss in either."""
    true = np.array([5e-3, 0.0, 0.2, 0.0, 0.0])
    points = np.tile(place(jaw, true), (3, 1))
    one, miss_one = nearest_poses(jaw, points, LOW, HIGH, true)
    other, miss_other = nearest_poses(jaw, points, LOW, HIGH, true + [2e-3, 2e-3, 0.0, 0.03, 0.05])
    assert max(miss_one.max(), miss_other.max()) < 1e-9
    np.testing.assert_allclose(one[-1], true, atol=1e-9)
    assert np.linalg.norm((other - one)[-1, :2]) > 1e-3


def test_two_directions_do_not_move_the_point(jaw):
    q = np.array([5e-3, 5e-4, 0.2, 0.02, 0.01])
    directions, values = null_directions(jaw, q, WIDTH)
    assert directions.shape == (2, 5) and values.min() > 1e-4
    for direction in directions:
        moved = [np.linalg.norm(place(jaw, q + h * direction) - place(jaw, q)) for h in (1e-2, 1e-3)]
        assert moved[1] < 0.02 * moved[0], "of second order in the step"


def test_the_range_that_bounds_leave_is_wide_and_its_ends_are_reached(jaw):
    """An opening of 11 degrees: roll is anything, and lateral slide and yaw trade for each other to a bound."""
    q = np.array([5e-3, 5e-4, 0.2, 0.02, 0.01])
    extremes = compatible_range(jaw, q, LOW, HIGH)
    assert (extremes[:, 0] <= q + 1e-9).all() and (extremes[:, 1] >= q - 1e-9).all()
    share = (extremes[:, 1] - extremes[:, 0]) / WIDTH
    assert share[1] > 0.6 and share[3] > 0.2 and share[4] > 0.99
    # No pose of the surface lies outside: drawn by moving along the null directions and back onto the surface.
    rng = np.random.default_rng(5)
    for start in rng.uniform(LOW, HIGH, (40, 5)):
        poses, misses = nearest_poses(jaw, place(jaw, q)[None], LOW, HIGH, start)
        if misses[0] < 1e-9:
            assert (poses[0] >= extremes[:, 0] - 1e-4 * WIDTH).all() and (
                poses[0] <= extremes[:, 1] + 1e-4 * WIDTH
            ).all()


def test_a_point_out_of_reach_is_missed_by_what_is_said(jaw):
    far = place(jaw, np.array([5e-3, 0.0, 0.2, 0.0, 0.0])) + [0.05, 0.0, 0.0]
    poses, misses = nearest_poses(jaw, far[None], LOW, HIGH, 0.5 * (LOW + HIGH))
    assert misses[0] > 0.02
    assert misses[0] == pytest.approx(np.linalg.norm(place(jaw, poses[0]) - far))


def test_wrong_input_is_named(jaw):
    middle = 0.5 * (LOW + HIGH)
    with pytest.raises(InputError, match="points has shape"):
        nearest_poses(jaw, np.zeros((2, 6)), LOW, HIGH, middle)
    with pytest.raises(InputError, match="start is"):
        nearest_poses(jaw, np.zeros((2, 3)), LOW, HIGH, HIGH + 1.0)
    with pytest.raises(InputError, match="lower is"):
        compatible_range(jaw, middle, HIGH, LOW)
