"""The twin's jaw against the jaw of the environments."""

import numpy as np
import pytest
import torch

import jawenv
from agents.twin.mechanics import Jaw, force_noise, shaken_information, shaking
from jawenv.mechanics import build_jaw
from jawenv.mechanics.acceleration import acceleration

POSES = np.array([[4e-3, 1e-3, 0.15, 0.05, -0.06], [-0.2e-3, -2e-3, -0.01, -0.03, 0.1], [12.9e-3, 0.0, 0.4, 0.1, 0.0]])
STEP = 1e-6


@pytest.fixture
def record():
    return build_jaw(head_tilt_deg=10.0)


def rows_of(values):
    return torch.tensor(np.atleast_2d(values))


def passive(record, pose, theta):
    jaw = Jaw.of(record)
    return jaw.passive(jaw.pose(rows_of(pose)), rows_of(theta))


def mass_matrix(jaw, pose):
    """(5, 5) of (x', y', theta', psi', alpha') from the kinetic energy of the independent jaw."""
    place = Jaw.of(jaw).pose(rows_of(pose))
    Z = place.twists[0].numpy()
    J = place.motion(place.arms(torch.tensor(jaw["centre_of_mass"]))[0])[0].numpy()
    turned = place.turned[0].numpy()
    return jaw["mass"] * J[:, :3] @ J[:, :3].T + Z[:, 3:] @ turned @ jaw["inertia"] @ turned.T @ Z[:, 3:].T


@pytest.mark.parametrize("pose", POSES)
def test_a_jaw_at_rest_accelerates_by_the_generalised_forces(record, rng, pose):
    theta = jawenv.cohort("one_sided").draw_log_parameters(rng)
    forces = passive(record, pose, theta).forces.force[0].numpy()
    rates = np.linalg.solve(mass_matrix(record, pose), forces)
    expected = acceleration(record, pose, np.zeros(5), theta, np.zeros(6))
    place = Jaw.of(record).pose(rows_of(pose))
    axes = (place.turned.mT @ place.twists[:, 2:, 3:].mT)[0].numpy()  # omega in body axes = axes @ angle rates
    np.testing.assert_allclose(np.concatenate([rates[:2], axes @ rates[2:]]), expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("pose", POSES)
def test_the_stiffness_is_the_derivative_of_the_forces(record, rng, pose):
    theta = jawenv.cohort("one_sided").draw_log_parameters(rng)
    K = passive(record, pose, theta).forces.stiffness[0].numpy()
    steps = STEP * np.eye(5)
    differences = [
        (passive(record, pose + d, theta).forces.force - passive(record, pose - d, theta).forces.force)[0].numpy()
        for d in steps
    ]
    np.testing.assert_allclose(K, -np.array(differences).T / (2 * STEP), rtol=1e-4, atol=1e-3)
    np.testing.assert_allclose(K, K.T, atol=1e-9)


def test_columns_are_the_derivatives_by_the_parameters(record, rng):
    pose, theta = POSES[0], jawenv.cohort("trismus").draw_log_parameters(rng)
    carried = passive(record, pose, theta)
    for i, d in enumerate(STEP * np.eye(12)):
        change = passive(record, pose, theta + d).forces.force - passive(record, pose, theta - d).forces.force
        np.testing.assert_allclose(carried.columns[0, :, i], change[0] / (2 * STEP), rtol=1e-6, atol=1e-8)


def test_the_noise_is_the_wrench_s_and_grows_with_the_encoders(record, rng):
    theta = rows_of(jawenv.cohort("trismus").draw_log_parameters(rng))
    jaw = Jaw.of(record)
    pose = jaw.pose(rows_of(POSES[0]))
    carried = jaw.passive(pose, theta)
    J = pose.motion(pose.arms(jaw.mouthpiece[None])[:, 0])
    variance, sd = torch.full((1, 6), 1e-2), torch.full((6,), 1e-9, dtype=torch.float64)
    noise = force_noise(carried, J, variance, sd)
    torch.testing.assert_close(noise, (J * variance[:, None]) @ J.mT)
    more = force_noise(carried, J, variance, torch.full((6,), 1e-3, dtype=torch.float64))
    assert (torch.linalg.eigvalsh(more - noise) > -1e-6).all()


def test_shaking_solves_its_equation_and_informs_symmetrically(record, rng):
    parts = torch.tensor(rng.standard_normal((3, 1, 5, 5)))
    K, D, noise = parts @ parts.mT + 5.0 * torch.eye(5)
    K = 100.0 * K  # far from what counts as unstable
    C = shaking(K, D, noise)
    torch.testing.assert_close(K @ C @ D + D @ C @ K, noise)
    information = shaken_information(passive(record, POSES[0], np.ones(12)), C, noise)
    assert (torch.linalg.eigvalsh(information) > -1e-9 * information.abs().max()).all()
