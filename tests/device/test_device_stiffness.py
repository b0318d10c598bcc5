"""The bound on how fast the device can swing the jaw, and a tick of the truth that stops and brake make stiff."""

import gymnasium as gym
import newton_euler as twin
import numpy as np
import pytest

from jawenv.device.device import TICK
from jawenv.device.motors import (
    BRAKED,
    CAPPED,
    IDLE,
    ON_PATH,
    STOPPED,
    STOPPED_AND_BRAKED,
    YIELD_FORCE,
    device_wrench,
    held_rate,
)
from jawenv.envs.world.plants import SUBSTEPS, midline_steps, midline_tick, true_motion
from jawenv.filter.readings.cell_trend import mean_reading
from jawenv.mechanics.dynamics import state_rate
from jawenv.mechanics.stiffness import fastest_rate

STEP = 1e-7


class Tick:
    """One world at the start of a tick, and what moves it."""

    def __init__(self, control, seed=2):
        env = gym.make("jawenv/Jaw-v3", control=control).unwrapped
        env.reset(seed=seed)
        simulation = env.simulation
        self.world, self.device, self.settings = simulation.worlds[0], simulation.device[0], simulation.settings[0]
        self.scratch, self.trajectory = simulation.scratches[0], np.uint8(control == "trajectory")
        self.scratch["effective"] = self.world["truth"]["muscles"]
        self.world["known"]["motors"]["cap"] = 50.0

    def wrench(self, state, since=0.0):
        """The device's, and the state as two tuples."""
        wrench, _, q, u = self.governed(state, since)
        return wrench, q, u

    def governed(self, state, since=0.0):
        """The same, and what of the governor acts."""
        truth, known = self.world["truth"], self.world["known"]
        q, u = (tuple(float(v) for v in half) for half in np.split(state, 2))
        wrench, acted = device_wrench(
            self.device, truth["jaw"], known["limits"], known["motors"], (q, u, ON_PATH), since, self.trajectory
        )
        return wrench, acted, q, u

    def rate(self, state, since=0.0):
        """(10,) rate of the state under the device."""
        wrench, q, u = self.wrench(state, since)
        q_rate, u_rate = state_rate(self.world["truth"]["jaw"], self.world["truth"]["muscles"], q, u, wrench)
        return np.array(q_rate + u_rate)

    def hurried(self, rng):
        """The tick's first state, at several times the soft speed."""
        state = self.world["truth"]["state"].copy()
        state[5:] += rng.normal(size=5) * [0.05, 0.05, 2.0, 3.0, 2.0]
        return state

    def path(self, state, parts=64):
        """(parts + 1, 10) states along the tick, by small steps of the independent model."""
        states, h = [state], TICK / parts
        for step in range(parts):
            states.append(twin.runge_kutta(lambda since, s, t=step * h: self.rate(s, t + since), states[-1], h))
        return np.array(states)

    def fastest(self, state):
        """The largest eigenvalue of the motion near a state, by differences."""
        columns = [(self.rate(state + STEP * one) - self.rate(state - STEP * one)) / (2 * STEP) for one in np.eye(10)]
        return np.abs(np.linalg.eigvals(np.column_stack(columns))).max()

    def bound(self, state):
        jaw = self.world["truth"]["jaw"]
        own = fastest_rate(jaw, self.world["truth"]["muscles"], tuple(float(v) for v in state[:5]))
        return held_rate(self.device, jaw, self.trajectory, self.governed(state)[1], own)


@pytest.mark.parametrize("control", ["force", "trajectory"])
def test_no_mode_is_faster_than_the_bound(control, rng):
    """Past the stops of opening and slide, or fast, or held by the servos alone, for what acts there.

    Of a jaw that nothing holds the bound is the mechanics' own, which knows no damping.
    """
    tick, shares = Tick(control), {}
    for _ in range(90):
        state = tick.world["truth"]["state"].copy()
        state[:5] += rng.uniform(0.0, 1.0, 5) * [3e-3, 5e-3, 0.3, 0.05, 0.05] * rng.choice([0.1, 1.0])
        state[5:] += rng.normal(size=5) * [0.05, 0.05, 1.0, 1.0, 1.0] * rng.choice([0.05, 1.0])
        acted = tick.governed(state)[1]
        if acted >= BRAKED or control == "trajectory":
            shares.setdefault(acted, []).append(tick.fastest(state) / tick.bound(state))
    assert {BRAKED, STOPPED, STOPPED_AND_BRAKED} <= shares.keys()
    assert (IDLE in shares) == (control == "trajectory")
    assert max(max(values) for values in shares.values()) < 1.0, {
        acted: max(values) for acted, values in shares.items()
    }
    assert max(shares[STOPPED]) > 0.1, "a bound, and not a useless one"


def test_each_part_of_the_governor_adds_to_the_rate():
    """The cap adds nothing; servos do where there are any; motors that yield to stops and brake add to these."""
    tick = Tick("force")
    jaw, device = tick.world["truth"]["jaw"], tick.device
    yielding = 1.0 + 2.0 * float(device["full_scale"]) / YIELD_FORCE

    def rate(acted, trajectory=0, free_rate=0.0):
        return held_rate(device, jaw, np.uint8(trajectory), acted, free_rate)

    def root(spring, damper):
        return np.roots([1.0, -damper, -spring]).max()

    assert rate(IDLE) == rate(CAPPED) == 0.0 and rate(IDLE, free_rate=120.0) == 120.0
    brake = yielding * float(jaw["mouthpiece_mobility"] * device["brake"])
    assert rate(BRAKED) == pytest.approx(brake)
    stops = yielding * float(jaw["mouthpiece_mobility"] + jaw["condyle_mobility"])
    spring, damper = stops * float(device["stop_stiffness"]), stops * float(device["stop_damping"])
    assert rate(STOPPED, free_rate=200.0) == pytest.approx(root(200.0**2 + spring, damper))
    assert rate(STOPPED_AND_BRAKED) == pytest.approx(root(spring, damper + brake))
    servos = 2.0 * float(jaw["mouthpiece_mobility"])
    spring, damper = servos * float(device["servo_stiffness"]), servos * float(device["servo_damping"])
    assert rate(IDLE, trajectory=1) == pytest.approx(root(spring, damper))


@pytest.mark.parametrize("control", ["force", "trajectory"])
def test_a_tick_in_which_the_brake_works_is_resolved(control, rng):
    """A jaw at several times the soft speed, against steps of a 64th of a tick; the usual steps are far off."""
    apart = {"taken": 0.0, "usual": 0.0}
    for _ in range(10):
        tick = Tick(control)
        start = tick.hurried(rng)
        fine = tick.path(start)[-1]
        for name in apart:
            tick.world["truth"]["state"] = start
            if name == "taken":
                assert midline_tick(tick.device, tick.world, tick.scratch, tick.settings) >= BRAKED
            else:
                midline_steps(tick.device, tick.world, tick.scratch, tick.settings, SUBSTEPS)
            apart[name] = max(apart[name], np.abs(tick.world["truth"]["state"] - fine)[2:5].max())
    assert apart["taken"] < 1e-4 < apart["usual"], apart


@pytest.mark.parametrize("control", ["force", "trajectory"])
def test_the_load_cell_reads_the_mean_of_what_the_brake_does(control, rng):
    """Against steps of a 64th of a tick; samples of the force at their moments are ten times as far off its mean."""
    apart = {"read": 0.0, "sampled": 0.0}
    for _ in range(10):
        tick = Tick(control)
        start = tick.hurried(rng)
        forces = [tick.wrench(state, step * TICK / 64)[0][:3] for step, state in enumerate(tick.path(start))]
        tick.world["truth"]["state"] = start
        assert true_motion(tick.device, tick.world, tick.scratch, tick.settings) >= BRAKED
        exact = np.trapezoid(forces, dx=1 / 64, axis=0)
        read = [mean_reading(tick.scratch["wrench"], k) for k in range(3)]
        sampled = (np.array(forces[0]) + 4.0 * np.array(forces[32]) + forces[64]) / 6.0
        apart["read"] = max(apart["read"], np.abs(read - exact).max())
        apart["sampled"] = max(apart["sampled"], np.abs(sampled - exact).max())
    assert apart["read"] < 0.1 * apart["sampled"], apart
