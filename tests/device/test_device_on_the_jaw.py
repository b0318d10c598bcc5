"""The device on jaws of the default cohort: governor, servo, integration step."""

import gymnasium as gym
import newton_euler as twin
import numpy as np
import pytest

from jawenv.device.comfort import COMFORT_LIMITS, GOVERNOR_ONSET
from jawenv.device.comfort_settings import Comfort
from jawenv.device.device import TICK
from jawenv.device.motors import ON_PATH, command_motors, device_wrench
from jawenv.envs.world.plants import SUBSTEPS
from jawenv.mechanics.dynamics import state_rate

ID = "jawenv/Jaw-v3"
PATIENTS = 16
FULL = {"open": (1, 1, 0, 0), "left": (0, 0, -1, 1), "forward": (0, 0, 1, 1), "back": (0, 0, -1, -1)}
# How many of the patients' hard limits may be crossed: where the painless range is short, the condyles' stop gives way.
VIOLATIONS = {"open": 0, "left": 0, "forward": 2, "back": 0}


@pytest.mark.parametrize("control", ["force", "trajectory"])
@pytest.mark.parametrize("way", FULL)
def test_full_thrust_for_ever_is_held_by_the_governor(control, way):
    env = gym.make_vec(ID, num_envs=PATIENTS, control=control, episode_s=6.0, autoreset_mode="disabled")
    env.reset(seed=100)
    used, governor = [], []
    for _ in range(120):
        *_, info = env.step(np.tile(np.array(FULL[way], dtype=np.float32), (PATIENTS, 1)))
        used.append([info[f"comfort_{name}"] for name in COMFORT_LIMITS])
        governor.append(info["governor"])
    assert info["violation"].sum() <= VIOLATIONS[way]
    worst = dict(zip(COMFORT_LIMITS, np.max(used, axis=(0, 2)), strict=True))
    for name, hard in zip(COMFORT_LIMITS, Comfort().records()["hard"][0], strict=True):
        assert worst[name] <= (1.03 * hard if VIOLATIONS[way] else hard), worst
    assert worst["force"] <= 1 + GOVERNOR_ONSET * (Comfort().force_hard - 1) + 1e-9
    assert np.mean(governor) > 0.25, "the governor is at work"


def test_the_governor_leaves_small_motion_alone():
    env = gym.make_vec(ID, num_envs=PATIENTS, episode_s=4.0, control="force")
    env.reset(seed=100)
    for k in range(80):
        action = 0.05 * np.sin(2 * np.pi * k / 80) * np.array([1, 1, -1, 1], dtype=np.float32)
        *_, info = env.step(np.tile(action, (PATIENTS, 1)))
        np.testing.assert_array_equal(info["governor"], 0.0)
        assert info["cost"].max() < 0.01, "the unmodelled force alone shakes the jaw to the soft speed now and then"


def test_the_servo_takes_the_jaw_where_the_target_goes():
    """A quarter of the largest rate for a second opens by 10 mm, less what the servos' springs give way."""
    env = gym.make_vec(ID, num_envs=PATIENTS, control="trajectory", episode_s=3.0)
    env.reset(seed=100)
    worlds, jaw = env.simulation.worlds, env.simulation.worlds["truth"]["jaw"][0]

    def opening():
        return np.array([jaw["mouthpiece"][2] - twin.measurement(jaw, state)[2] for state in worlds["truth"]["state"]])

    start, thrust = opening(), worlds["known"]["motors"]["thrust"][:, :2].mean(axis=1)
    for k in range(60):
        env.step(np.tile(np.array([0.25, 0.25, 0, 0], dtype=np.float32) * (k < 20), (PATIENTS, 1)))
    moved = opening() - start
    rise = worlds["known"]["motors"]["thrust"][:, :2].mean(axis=1) - thrust
    given_way = rise / env.simulation.device["servo_stiffness"][0]
    assert (np.abs(moved + given_way - 0.010) < 2e-4).all(), moved + given_way
    assert (moved > 0.005).all() and given_way.max() > 1e-3


def opening_and_turning(t):
    """Off the teeth."""
    return 0.1 * np.array([*[np.sin(0.5 * np.pi * t) ** 2] * 2, *np.sin(1.4 * np.pi * t) * np.array([1, -1])])


def biting(t):
    """Onto the teeth every two seconds."""
    return 0.1 * np.array([*[np.sin(np.pi * t)] * 2, *np.sin(1.4 * np.pi * t) * np.array([1, -1])])


def simulate(environment, motion, trajectory, substeps):
    """(600, 10) states of six seconds of the truth without noise, by Runge-Kutta steps of TICK / substeps."""
    world, device = environment.simulation.worlds[0].copy(), environment.simulation.device[0]
    truth, limits, motors = world["truth"], world["known"]["limits"], world["known"]["motors"]
    jaw, start = truth["jaw"], truth["state"]
    muscles, state, path = truth["muscles"], start.copy(), []
    h = TICK / substeps
    for tick in range(600):
        action = motion(tick * TICK) * (1.0 if trajectory else 0.5)
        q, u = tuple(state[:5]), tuple(state[5:])
        command_motors(device, jaw, motors, (q, u, ON_PATH), action, np.uint8(trajectory), TICK)
        for substep in range(substeps):

            def rate(since, s, before=substep * h):
                q, u = tuple(s[:5]), tuple(s[5:])
                wrench, _ = device_wrench(
                    device, jaw, limits, motors, (q, u, ON_PATH), before + since, np.uint8(trajectory)
                )
                q_rate, u_rate = state_rate(jaw, muscles, q, u, wrench)
                return np.array(q_rate + u_rate)

            state = twin.runge_kutta(rate, state, h)
        if trajectory:
            motors["target"] += motors["rate"] * TICK
        path.append(state)
    return np.array(path)


@pytest.mark.parametrize("control", ["force", "trajectory"])
@pytest.mark.parametrize(("motion", "place_m", "angle"), [(opening_and_turning, 1e-6, 1e-5), (biting, 5e-6, 8e-5)])
def test_half_the_integration_step_changes_nothing_that_matters(control, motion, place_m, angle):
    """On the teeth less than a twentieth of the encoders' noise, off them much less."""
    env = gym.make(ID, control=control, cohort="healthy", device={"brake_N_s_m": 0.0}).unwrapped
    env.reset(seed=2)
    coarse, fine = (simulate(env, motion, control == "trajectory", n) for n in (SUBSTEPS, 2 * SUBSTEPS))
    assert np.ptp(coarse[:, 2]) > 0.02, "it does open"
    assert np.ptp(coarse[:, 3]) > 0.04, "and turn"
    apart = np.abs(coarse - fine).max(axis=0)
    assert (apart[:2] < place_m).all(), apart
    assert (apart[2:5] < angle).all(), apart
