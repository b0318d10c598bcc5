"""What is wrong in Young (2016) without an equation of its own (docs/model.md)."""

import newton_euler as twin
import numpy as np
import pytest
from printed_equations import cross_matrix, therapy_states
from scipy.spatial.transform import Rotation

import jawenv
from jawenv.anatomy import default_mandible, known_muscle_sets
from jawenv.filter.model.encoders import measure
from jawenv.ladder import MODELS
from jawenv.mechanics import build_jaw
from jawenv.mechanics.dynamics import linear_dtype
from jawenv.mechanics.equilibrium import settle


def rest_of(jaw, log_parameters):
    """Pose (5) of the midline model at rest, or None."""
    pose, scratch = np.array([3e-3, 0.0, 0.05, 0.0, 0.0]), np.zeros(1, dtype=linear_dtype(6))[0]
    muscles = np.exp(log_parameters).reshape(6, 2)
    _, found = settle(jaw, muscles, pose, 0.0, False, scratch, np.empty((5, 5)), np.empty(5))
    return pose if found else None


def opening_of(jaw, pose):
    return jaw["mouthpiece"][2] - twin.measurement(jaw, np.concatenate([pose, np.zeros(5)]))[2]


def test_without_teeth_the_jaw_closes_too_far(jaw) -> None:
    jaw["tooth_stiffness"] = 1e-6
    poses = [rest_of(jaw, np.log(np.tile([F_o, 10.0], 6))) for F_o in (4.0, 10.0)]
    np.testing.assert_allclose([-1e3 * opening_of(jaw, pose) for pose in poses], [24.5, 39.4], rtol=0.02)


def test_elimination_of_the_normal_force_divides_by_a_large_number_in_therapy() -> None:
    """Equations 4.30-4.35 with Q, the normal and the axes corrected: v = Q^-1 C n, of which v_x is divided by."""
    shares = []
    for s in therapy_states():
        m, rho = s.twin.mandible.mass_kg, cross_matrix(s.twin.mandible.centre_of_mass_m)
        slope = s.twin.height(s.q[0])[1]
        Q = np.eye(3) + m * rho @ np.linalg.solve(s.M[3:, 3:], rho)
        v = s.R @ np.linalg.solve(Q, s.R.T @ [-slope, 0.0, 1.0])
        shares.append(v[0] / np.linalg.norm(v))
    assert min(shares) == pytest.approx(0.71, abs=0.006)


def test_one_point_does_not_determine_five_coordinates(jaw, rng) -> None:
    for _ in range(20):
        state = np.concatenate([[rng.uniform(1e-3, 1e-2)], rng.uniform(-0.2, 0.4, 4), rng.uniform(-0.1, 0.1, 5)])
        rows, expected = np.empty((12, 10)), np.empty(12)
        measure(jaw, state, rows, expected)
        assert np.linalg.matrix_rank(rows[:3, :5]) == 3
        assert np.linalg.matrix_rank(rows[:6, :5]) == 5
        assert np.linalg.matrix_rank(rows[[0, 1, 2, 6, 7, 8]]) == 6 < 10


def test_the_hinge_is_one_moment_balance() -> None:
    """(I_*)_22 theta'' = moment of device and weight less that of the muscle and of damping; Young, eqs. A.25-A.26."""
    muscles, mandible = known_muscle_sets()["closers"], default_mandible()
    jaw = build_jaw(muscles, free=MODELS["hinge"].free)
    origin, insertion, l_o = muscles.origin_m[0], muscles.insertion_m[0], muscles.l_o_m[0]
    F_o, b, theta, rate, down = 7.0, 7.0, 0.3, 0.2, 9.0
    turn = Rotation.from_euler("y", theta)
    arm, centre, mouth = (
        turn.apply(np.array(p)) for p in (insertion, mandible.centre_of_mass_m, mandible.mouthpiece_m)
    )
    line = origin - arm
    tension = F_o * np.exp(b * (np.linalg.norm(line) / l_o - 1)) + 6 * mandible.closing_tone_N
    muscle = np.cross(arm, tension * line / np.linalg.norm(line))[1]
    weight = np.cross(centre, [0, 0, -mandible.mass_kg * mandible.gravity])[1]
    device = np.cross(mouth, [0, 0, -down])[1]
    assert muscle < 0 < device, "they oppose each other"
    m, rho = mandible.mass_kg, mandible.centre_of_mass_m
    inertia = mandible.inertia_kg_m2[1, 1] + m * rho @ rho
    expected = (device + weight + muscle - mandible.damping_rotation * rate) / inertia
    wrench = turn.inv().apply([0, 0, -down])
    found = jawenv.acceleration(jaw, [0, 0, theta, 0, 0], [0, 0, 0, rate, 0], np.log([F_o, b]), wrench)
    np.testing.assert_allclose(found, [0, 0, 0, expected, 0], rtol=1e-12)
