"""Hinge and plane are the midline model with coordinates held: by the constraint forces that hold them."""

import newton_euler as twin
import numpy as np
import pytest

import jawenv
from jawenv.ladder import MODELS
from jawenv.mechanics import build_jaw


def holding_wrenches(jaw, q, free):
    """Device wrenches (6,) that push along the held coordinates alone: at the contact point, or as pure moments."""
    R, slope = twin.rotation(q), twin.fossa(jaw, q[0])[1]
    pushes = {0: np.array([1.0, 0.0, slope]), 1: np.array([0.0, 1.0, 0.0])}
    wrenches = []
    for i in (0, 1):
        if not free[i]:
            force = R.T @ pushes[i]
            wrenches.append(np.concatenate([force, np.cross(-jaw["mouthpiece"], force)]))
    if not free[3]:
        wrenches += [np.r_[0, 0, 0, 1.0, 0, 0], np.r_[0, 0, 0, 0, 0, 1.0]]
    return np.array(wrenches)


@pytest.mark.parametrize("name", ["hinge", "sagittal"])
def test_held_coordinates_do_not_accelerate_and_the_others_as_if_held_by_force(rng, name):
    model = MODELS[name]
    held_jaw = build_jaw(model.muscles, free=model.free)
    free_jaw = build_jaw(model.muscles)
    # u is x', y', roll, pitch, yaw.
    moves = np.array([model.free[0], model.free[1], model.free[4], model.free[2], model.free[3]])
    for _ in range(50):
        q = np.array([rng.uniform(1e-3, 9e-3) * model.free[0], 0.0, rng.uniform(0.0, 0.5), 0.0, 0.0])
        u = np.where(moves, rng.uniform(-0.3, 0.3, 5), 0.0)
        muscles = rng.uniform([0.5, 4.0], [5.0, 12.0], (len(model.muscles), 2))
        theta = np.log(muscles).ravel()
        wrench = np.concatenate([rng.uniform(-10, 10, 3), rng.uniform(-0.3, 0.3, 3)])

        def accelerate(w, q=q, u=u, theta=theta):
            return np.array(jawenv.acceleration(free_jaw, q, u, theta, w))

        plain, pushes = accelerate(wrench), holding_wrenches(free_jaw, q, model.free)
        response = np.array([accelerate(wrench + push) - plain for push in pushes]).T
        strength = np.linalg.solve(response[~moves], -plain[~moves])
        expected = accelerate(wrench + strength @ pushes)
        actual = np.array(jawenv.acceleration(held_jaw, q, u, theta, wrench))
        np.testing.assert_array_equal(actual[~moves], 0.0)
        np.testing.assert_allclose(actual[moves], expected[moves], rtol=1e-8, atol=1e-8 * np.abs(plain).max())
