"""Ten seconds of forced motion: jawenv's Runge-Kutta steps against MuJoCo's body under an adaptive integrator.

jawenv moves Euler angles with the step of 5 ms that the true motion takes in the environment. The twin moves a
quaternion with DOP853 at a tolerance far below. Both are compared as places and orientations of the mandible.
"""

import numpy as np
import pytest
from jaw_motion import motion, random_patient
from mujoco_twin import MujocoTwin
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from jawenv.mechanics import build_jaw

SECONDS, STEP = 10.0, 5e-3
TIMES = np.linspace(0, SECONDS, 1001)


def therapy(down, side):
    """A slow pull on the mouthpiece with sideways and turning parts of other periods."""

    def wrench(t):
        force = [0.3 * np.sin(1.9 * t), side * np.sin(3.3 * t + 1), -down * (1 - np.cos(2.5 * t)) / 2]
        return np.array([*force, 0.01 * np.sin(4.4 * t), 0.02 * np.cos(1.3 * t), 0.01 * np.sin(5.7 * t)])

    return wrench


def twin_motion(log_parameters, start, wrench):
    """Condyle's (x, y), orientation and the states at ``TIMES``."""
    twin = MujocoTwin()
    found = solve_ivp(
        lambda t, s: twin.state_rate(s, log_parameters, wrench(t)),
        (0, SECONDS),
        twin.state(start[:5], start[5:]),
        method="DOP853",
        rtol=1e-10,
        atol=1e-13,
        t_eval=TIMES,
    )
    assert found.success
    w, x, y, z = found.y[2:6]
    return found.y[:2].T, Rotation.from_quat(np.column_stack([x, y, z, w]))


# Largest errors in m and rad at 5 ms; halved steps leave less than a sixth of them.
@pytest.mark.parametrize(
    ("cohort", "down", "side", "place_m", "turn_rad"),
    [
        pytest.param("healthy", 4.0, 0.5, 5e-7, 2e-5, id="opened wide and shifted"),
        pytest.param("trismus", 20.0, 1.0, 8e-5, 2e-3, id="snapping shut onto the teeth and the fossa's back"),
    ],
)
def test_steps_of_5_ms_follow_mujocos_body(cohort, down, side, place_m, turn_rad):
    log_parameters, jaw = random_patient(np.random.default_rng(3), cohort), build_jaw()
    start, wrench = np.array([3e-3, 0, 0.1, 0, 0, 0, 0, 0, 0, 0]), therapy(down, side)
    places, turns = twin_motion(log_parameters, start, wrench)
    errors = []
    for step in (STEP, STEP / 2):
        every = round(TIMES[1] / step)
        states = motion(jaw, log_parameters, start, wrench, step, round(SECONDS / step))[::every]
        off_place = np.abs(states[:, :2] - places).max()
        off_turn = (Rotation.from_euler("YZX", states[:, 2:5]).inv() * turns).magnitude().max()
        print(f"{cohort}, {1e3 * step:.1f} ms: {off_place:.1e} m, {off_turn:.1e} rad")
        errors.append((off_place, off_turn))
    assert np.ptp(states[:, 2]) > 0.2, "the mouth does open"
    coarse, fine = np.array(errors)
    assert np.all(coarse < (place_m, turn_rad))
    assert np.all(fine < coarse / 6)
