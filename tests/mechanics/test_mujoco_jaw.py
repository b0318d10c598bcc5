"""The jaw that MuJoCo moves: near the midline model where that is right, and the same episode every time."""

import gymnasium as gym
import numpy as np
import pytest

import jawenv
from jawenv.mechanics import build_jaw
from jawenv.mechanics.dynamics import linear_dtype
from jawenv.mechanics.equilibrium import settle
from jawenv.mechanics.kinematics import contact_point
from jawenv.mechanics.plant import PatientJaw, body_motion, checked_motion, motion_at_mouthpiece
from tests.passive_opening import passive_opening

mujoco_jaw = pytest.importorskip("jawenv.mechanics.mujoco_jaw")
NAME = "jawenv.mechanics.mujoco_jaw:MujocoJaw"
PULLS_N = (5.0, 10.0, 20.0)


def patient_of(log_parameters):
    jaw, law = build_jaw(), np.exp(log_parameters).reshape(-1, 2)
    pose = np.array([3e-3, 0.0, 0.05, 0.0, 0.0])
    scratch = np.zeros(1, dtype=linear_dtype(6))[0], np.empty((5, 5)), np.empty(5)
    assert settle(jaw, law, pose, 0.0, False, *scratch)[1]
    rest = motion_at_mouthpiece(((*contact_point(jaw, tuple(pose)), *pose[2:]), (0.0,) * 6), jaw["mouthpiece"])
    return PatientJaw(jaw, jawenv.MUSCLE_NAMES, law[:, 0], law[:, 1], rest)


def drawn(seed):
    return jawenv.cohort("trismus").draw(np.random.default_rng(seed)).log_parameters()


def opening_mm(plant, patient):
    return 1e3 * (patient.jaw["mouthpiece"][2] - plant.motion.place_m[2])


@pytest.mark.parametrize("seed", [0, 1])
def test_it_rests_and_opens_about_where_the_midline_model_does(seed):
    theta = drawn(seed)
    patient, plant = patient_of(theta), mujoco_jaw.MujocoJaw()
    motion = checked_motion(plant.reset(patient, np.random.default_rng(0)), "rest")
    assert np.abs(motion.place_m - patient.rest.place_m).max() < 2e-3
    np.testing.assert_allclose(motion.velocity_m_s, 0.0, atol=1e-12)
    later = plant.advance(np.zeros(6), 0.1)
    np.testing.assert_allclose(later.place_m, motion.place_m, atol=1e-5)
    for pull, opening in zip(PULLS_N, passive_opening(theta, PULLS_N), strict=True):
        for _ in range(400):
            plant.advance(np.array([*(plant.motion.rotation.T @ [0.0, 0.0, -pull]), 0.0, 0.0, 0.0]), 1e-3)
            plant.data.qvel[:] *= 0.95
        assert opening_mm(plant, patient) == pytest.approx(opening, abs=2.0)


def test_speeds_are_those_of_places():
    patient, plant = patient_of(drawn(2)), mujoco_jaw.MujocoJaw()
    plant.reset(patient, np.random.default_rng(0))
    plant.advance(np.array([1.0, 1.0, -8.0, 0.0, 0.05, 0.05]), 0.05)
    before = plant.motion
    after = plant.advance(np.zeros(6), mujoco_jaw.TIMESTEP)
    speed = (after.place_m - before.place_m) / mujoco_jaw.TIMESTEP
    np.testing.assert_allclose(speed, after.velocity_m_s, atol=2e-4 + 0.01 * np.abs(speed).max())
    q, u = body_motion(after, patient.jaw["mouthpiece"])
    np.testing.assert_allclose(q[:3], plant.data.qpos[:3], atol=1e-15)
    np.testing.assert_allclose(u, plant.data.qvel, atol=1e-15)


def test_a_force_at_the_mouthpiece_and_its_moment_do_the_same_work_as_elsewhere():
    """A force and its moment about the mouthpiece, moved to the centre of mass, turn nothing."""
    patient, plant = patient_of(drawn(2)), mujoco_jaw.MujocoJaw()
    plant.reset(patient, np.random.default_rng(0))
    force = np.array([0.3, -0.5, 0.8])
    moment = np.cross(patient.jaw["centre_of_mass"] - patient.jaw["mouthpiece"], force)
    plant.advance(np.array([*force, *moment]), mujoco_jaw.TIMESTEP)
    np.testing.assert_allclose(plant.data.xfrc_applied[1, 3:], 0.0, atol=1e-15)


def test_a_disc_gives_way_as_the_anatomy_says():
    """A jaw without muscles and weight whose condyles are pressed against the slope of the eminence, and held there."""
    jaw = build_jaw()
    jaw["gravity"] = 0.0
    x = 0.5 * jaw["crest"]
    path = np.array(contact_point(jaw, (x, 0.0, 0.0, 0.0, 0.0)))
    rest = motion_at_mouthpiece(((*path, 0.3, 0.0, 0.0), (0.0,) * 6), jaw["mouthpiece"])
    plant = mujoco_jaw.MujocoJaw(ligaments=False)
    plant.reset(PatientJaw(jaw, jawenv.MUSCLE_NAMES, np.full(6, 1e-9), np.full(6, 7.0), rest), None)
    slope = -jaw["fossa_drop"] * jaw["fossa_frequency"] * np.sin(jaw["fossa_frequency"] * x)
    normal = np.array([-slope, 0.0, 1.0]) / np.hypot(1.0, slope)
    depth = mujoco_jaw.DISC_LOAD / jaw["disc_stiffness"]
    plant.data.qpos[:3] = path + depth * normal
    plant.data.qvel[:] = 0.0
    mujoco_jaw.mujoco.mj_forward(plant.model, plant.data)
    push = -plant.data.qfrc_constraint[:3] @ normal
    assert push == pytest.approx(2.0 * mujoco_jaw.DISC_LOAD, rel=0.15)


def test_equal_seeds_give_equal_episodes_to_the_bit_whatever_is_done():
    """Coarse commands, which take the jaw to stops and brakes."""
    env = gym.make("jawenv/Jaw-v3", plant=NAME, control="force", episode_s=3.0)
    commands = np.random.default_rng(0).choice([-1.0, 1.0], (12, 4)).repeat(5, axis=0).astype(np.float32)
    seen = []
    for _ in range(2):
        env.reset(seed=376000)
        for action in commands:
            observation, _, terminated, truncated, info = env.step(action)
            assert np.isfinite(observation).all() and np.isfinite(info["jaw_state"]).all()
            if terminated or truncated:
                break
        seen.append((observation, info["belief_mean"], info["jaw_state"]))
    for one, other in zip(*seen, strict=True):
        np.testing.assert_array_equal(one, other)


def test_what_is_no_multiple_of_its_step_is_refused():
    plant = mujoco_jaw.MujocoJaw()
    plant.reset(patient_of(drawn(0)), np.random.default_rng(0))
    with pytest.raises(jawenv.InputError, match="dt is 0.0007"):
        plant.advance(np.zeros(6), 7e-4)
