"""Energy along a motion: what the device puts in, less what damping takes, is what the jaw gains.

Kinetic energy comes from MuJoCo's mass matrix, the muscles' potential is the closed integral of their law, and the
powers come from MuJoCo's Jacobians. The error of the balance falls with the step as that of a method of fourth order.
"""

from dataclasses import replace

import numpy as np
import pytest
from jaw_motion import motion
from mujoco_twin import MujocoTwin

from jawenv.anatomy import default_mandible
from jawenv.mechanics import build_jaw

SECONDS = 2.0
START = np.array([5e-3, 0.3e-3, 0.2, 0.02, -0.01, 0.01, 0.005, 0.1, 0.2, -0.1])
# Without tone, which damps nothing either, weak muscles leave the jaw in the middle of its range, off kinks of stops.
UNDAMPED = replace(default_mandible(), damping_rotation=0.0, damping_sliding=0.0, closing_tone_N=0.0)


def free(_):
    return np.zeros(6)


def driven(t):
    force = [0.2 * np.sin(9 * t), 0.3 * np.sin(14 * t), -0.4 * np.sin(7 * t) ** 2]
    return np.array([*force, 0.01 * np.cos(11 * t), 0.0, 0.01])


def simpson(values, step):
    """Running integral at every second value of an odd number of values."""
    return np.concatenate([[0.0], np.cumsum((values[:-2:2] + 4 * values[1:-1:2] + values[2::2]) * step / 3)])


def balance(mandible, wrench, F_o, step):
    """Largest error of the balance, kinetic energy at its largest, work in and loss at the end (J)."""
    log_parameters = np.log(np.tile([F_o, 7.0], 6))
    jaw, twin = build_jaw(mandible=mandible), MujocoTwin(mandible)
    n = round(SECONDS / step)
    states = motion(jaw, log_parameters, START, wrench, step, n)
    states = [twin.state(state[:5], state[5:]) for state in states]
    energies = np.array([twin.energy(state, log_parameters) for state in states[::2]])
    powers = np.array([twin.powers(state, wrench(i * step)) for i, state in enumerate(states)])
    work, loss = simpson(powers[:, 0], step), simpson(powers[:, 1], step)
    total = energies.sum(axis=1)
    return np.abs(total - total[0] - work + loss).max(), energies[:, 0].max(), work[-1], loss[-1]


@pytest.mark.parametrize(
    ("mandible", "wrench"),
    [
        pytest.param(UNDAMPED, free, id="free"),
        pytest.param(None, free, id="damped"),
        pytest.param(UNDAMPED, driven, id="driven"),
        pytest.param(None, driven, id="driven and damped"),
    ],
)
def test_energy_is_accounted_for(mandible, wrench):
    coarse, *_ = balance(mandible, wrench, F_o=0.4, step=2e-3)
    fine, kinetic, work, loss = balance(mandible, wrench, F_o=0.4, step=1e-3)
    print(f"left over: {coarse:.1e} J at 2 ms, {fine:.1e} J at 1 ms, of {kinetic:.1e} J; in {work:.1e}, out {loss:.1e}")
    assert (work != 0) == (wrench is driven) and (loss > 0) == (mandible is None)
    assert fine < 1e-5 * kinetic
    assert coarse > 12 * fine


def test_biting_on_the_teeth_loses_no_energy():
    """Stiff muscles throw the jaw against teeth and capsule, whose force has kinks: the order is lower there."""
    coarse, *_ = balance(UNDAMPED, free, F_o=1.2, step=1e-3)
    fine, kinetic, _, _ = balance(UNDAMPED, free, F_o=1.2, step=0.5e-3)
    print(f"left over: {coarse:.1e} J at 1 ms, {fine:.1e} J at 0.5 ms, of {kinetic:.1e} J")
    assert fine < 1e-4 * kinetic
    assert coarse > 4 * fine
