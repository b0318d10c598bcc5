"""Two limits that are known without integrating: tiny motions are the linear model's, slow ones follow equilibrium.

Equilibria and the linear model come from MuJoCo's body: roots and differences of its accelerations.
"""

from dataclasses import replace

import numpy as np
import pytest
from jaw_motion import motion, random_patient
from mujoco_twin import MujocoTwin
from scipy.optimize import root

from jawenv.anatomy import default_mandible
from jawenv.mechanics import build_jaw

STILL = np.zeros(5)
UNITS = np.array([1e-3, 1e-3, 0.1, 0.1, 0.1])  # of q: about what matters
UNDAMPED = replace(default_mandible(), damping_rotation=0.0, damping_sliding=0.0)


def equilibrium(twin, log_parameters, wrench, guess):
    """Coordinates q at which MuJoCo's body stays where it is."""

    def left_over(scaled):
        return twin.acceleration(twin.state(scaled * UNITS, STILL), log_parameters, wrench)

    found = root(left_over, np.asarray(guess) / UNITS, tol=1e-13)
    assert np.abs(left_over(found.x)).max() < 1e-8
    return found.x * UNITS


def linear_model(twin, log_parameters, q):
    """d(q, u)'/d(q, u) at rest (10, 10), by five-point differences of MuJoCo's accelerations."""
    at_rest, steps = np.concatenate([q, STILL]), np.concatenate([UNITS, UNITS]) * 1e-2

    def rate(s):
        euler = np.linalg.solve(turning_axes(s[2:5]), s[7:])
        push = twin.acceleration(twin.state(s[:5], s[5:]), log_parameters, np.zeros(6))
        return np.concatenate([s[5:7], euler, push])

    columns = []
    for j, h in enumerate(steps):
        move = h * np.eye(10)[j]
        near = rate(at_rest + move) - rate(at_rest - move)
        far = rate(at_rest + 2 * move) - rate(at_rest - 2 * move)
        columns.append((8 * near - far) / (12 * h))
    return np.column_stack(columns)


def turning_axes(angles):
    """Body-frame axes of theta', psi', alpha' in columns; Young (2016), eq. 4.13."""
    _, psi, alpha = angles
    return np.array(
        [
            [np.sin(psi), 0, 1],
            [np.cos(alpha) * np.cos(psi), np.sin(alpha), 0],
            [-np.sin(alpha) * np.cos(psi), np.cos(alpha), 0],
        ]
    )


@pytest.mark.parametrize("mandible", [UNDAMPED, default_mandible()], ids=["undamped", "damped"])
@pytest.mark.parametrize("cohort", ["healthy", "one_sided"])
def test_tiny_motions_have_the_eigenvalues_of_mujocos_linear_model(mandible, cohort):
    """Started along an eigenvector, the motion turns and decays with its eigenvalue: all modes, each on its own."""
    log_parameters = random_patient(np.random.default_rng(5), cohort)
    twin, jaw = MujocoTwin(mandible), build_jaw(mandible=mandible)
    pull = np.zeros(6)
    rest = np.concatenate([equilibrium(twin, log_parameters, pull, [4e-3, 0, 0.15, 0, 0]), STILL])
    values, vectors = np.linalg.eig(linear_model(twin, log_parameters, rest[:5]))
    duals = np.linalg.inv(vectors)
    step, errors = 0.5e-3, []
    for i in np.flatnonzero(values.imag >= 0):
        vector = vectors[:, i] / np.abs(vectors[:5, i] / UNITS).max()
        start = rest + 1e-6 * vector.real
        n = round(min(2.0, 6 / max(abs(values[i].real), 1e-9)) / step)  # until it has died away
        states = motion(jaw, log_parameters, start, lambda _: pull, step, n)
        part = (states - rest) @ duals[i]
        logs = np.log(np.abs(part)) + 1j * np.unwrap(np.angle(part))
        measured = np.polyfit(step * np.arange(n + 1), logs, 1)[0]
        errors.append(abs(measured - values[i]) / abs(values[i]))
    frequencies = np.sort(values.imag[values.imag > 0]) / (2 * np.pi)
    print(f"{cohort}: {np.round(frequencies, 2)} Hz; largest relative error {max(errors):.1e}")
    assert values.real.max() < 1e-6
    assert max(errors) < 1e-5
    if mandible is UNDAMPED:
        assert len(frequencies) == 5


def test_slow_motion_follows_equilibrium():
    """The lag behind equilibrium is proportional to the speed of the pull."""
    log_parameters = random_patient(np.random.default_rng(5), "healthy")
    twin, jaw, step = MujocoTwin(), build_jaw(), 5e-3

    def pull(phase):
        return np.array([0, 0.3, -2.5, 0, 0, 0.02]) * np.sin(phase / 2) ** 2

    poses = [equilibrium(twin, log_parameters, pull(0), [4e-3, 0, 0.15, 0, 0])]
    phases = np.linspace(0, 2 * np.pi, 17)
    for phase in phases[1:]:
        poses.append(equilibrium(twin, log_parameters, pull(phase), poses[-1]))
    lags = []
    for seconds in (20.0, 40.0, 80.0):
        n = round(seconds / step)
        start = np.concatenate([poses[0], STILL])
        states = motion(jaw, log_parameters, start, lambda t, T=seconds: pull(2 * np.pi * t / T), step, n)
        lags.append((np.abs(states[:: n // 16, :5] - poses) / UNITS).max(axis=0))
    lags = np.array(lags)
    print("lag behind equilibrium (x, y in mm; angles in 0.1 rad):", lags.round(5).tolist())
    assert np.ptp(np.array(poses)[:, 2]) > 0.05, "the pull does open the mouth"
    np.testing.assert_allclose(lags[:-1] / lags[1:], 2.0, rtol=0.05)
