"""A step of the jaw that a servo holds, against the independent jaw's rates and SciPy's matrix exponential."""

import newton_euler as twin
import numpy as np
import pytest
import two_condyles
from recorded import recording
from running import Running
from scipy.linalg import expm

import jawenv
from jawenv.device.answer import add_servos
from jawenv.estimation.body_sensitivity import body_rate_and_sensitivity
from jawenv.estimation.closed_loop import LONGEST_PHASE, MOST_SQUARINGS, set_loop, set_rates, squarings_needed
from jawenv.estimation.line_wrenches import middle_of, set_by_place
from jawenv.estimation.sensitivity import rate_and_sensitivity
from jawenv.mechanics.kinematics import rotation

DEVICE = jawenv.Device().records()[0]
NOTHING = np.zeros(6)


class Loop:
    """A jaw with a servo about a state off the rest, all its kernels' working memory set."""

    def __init__(self, model, rng):
        record = recording(model).records[0]
        self.jaw, self.theta, self.wrench = (
            record.jaw,
            record.prior.mean,
            rng.normal(size=6) * [1, 1, 1, 0.02, 0.02, 0.02],
        )
        self.scratch, self.size = Running(record).scratch, len(record.start_mean)
        free = record.start_sd > 0.0
        self.state = record.start_mean + free * 0.3 * record.start_sd * rng.normal(size=self.size)
        muscles = np.exp(self.theta.reshape(-1, 2))[self.jaw["muscle"]]
        parts = tuple(tuple(float(v) for v in half) for half in np.split(self.state, 2))
        self.scratch["stage"] = 0.0
        rate = body_rate_and_sensitivity if self.size == 12 else rate_and_sensitivity
        rate(self.jaw, muscles, *parts, self.wrench, NOTHING, 0.0, 0.0, self.scratch)
        q, _ = middle_of(self.jaw, self.state, self.state)
        set_by_place(self.jaw, q, rotation(q), self.scratch)
        mouthpiece = tuple(float(v) for v in self.jaw["mouthpiece"])
        self.scratch["answer"] = 0.0
        add_servos(DEVICE, mouthpiece, self.scratch["by_place"], rotation(q), self.scratch["answer"])

    def state_rate(self, state, wrench):
        if self.size == 10:
            return twin.state_rate(self.jaw, self.theta, state, wrench)
        q, u = state[:6], state[6:]
        turning = np.linalg.solve(twin.angle_axes(two_condyles.five(q)), u[3:])
        return np.concatenate([u[:3], turning, two_condyles.acceleration(self.jaw, self.theta, q, u, wrench)])

    def rates(self):
        """(n, n + 6) of the closed loop by complex steps."""
        by_state = twin.derivative(lambda s: self.state_rate(s, self.wrench), self.state)
        by_wrench = twin.derivative(lambda w: self.state_rate(self.state, w), self.wrench)
        return np.hstack([by_state - by_wrench @ self.scratch["answer"], by_wrench])


MODELS = ["jaw", "hinge", "bilateral"]


@pytest.mark.parametrize("model", MODELS)
def test_the_rates_are_those_of_the_jaw_less_what_the_servo_takes(model, rng):
    loop = Loop(model, rng)
    set_rates(loop.scratch)
    expected = loop.rates()
    scale = np.abs(expected).max(axis=1, keepdims=True) + 1e-3
    np.testing.assert_allclose(loop.scratch["rates"] / scale, expected / scale, rtol=0, atol=1e-9)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("dt", [0.001, 0.01, 0.05])
def test_a_step_is_the_exponential_of_the_rates(model, dt, rng):
    """Sizes as the noise moves them: 0.1 mm, 0.1 degrees, and what a servo's swing makes of them in speed.

    The discs of two condyles bounce at 1200 rad/s, so that a quarter of 10 ms would not do for them.
    """
    loop = Loop(model, rng)
    n = loop.size
    set_rates(loop.scratch)
    whole = np.zeros((n + 6, n + 6))
    whole[:n] = loop.scratch["rates"]
    set_loop(dt, loop.scratch)
    sizes = np.concatenate([np.full(n // 2 - 3, 1e-4), np.full(3, 2e-3)])
    sizes = np.concatenate([sizes, 200.0 * sizes])
    inputs = np.append(sizes, [0.1, 0.1, 0.1, 0.003, 0.003, 0.003])
    exact = expm(dt * whole)[:n]
    wrong = (loop.scratch["loop"] - exact) * inputs / sizes[:, None]
    assert np.abs(wrong).max() < 0.02
    fastest = [np.abs(np.linalg.eigvals(matrix[:, :n])).max() for matrix in (loop.scratch["loop"], exact)]
    assert fastest[0] == pytest.approx(fastest[1], rel=1e-3)


@pytest.mark.parametrize("model", MODELS)
def test_no_motion_turns_far_in_a_part(model, rng):
    loop = Loop(model, rng)
    set_rates(loop.scratch)
    rates = loop.scratch["rates"].copy()
    fastest = np.abs(np.linalg.eigvals(rates[:, : loop.size])).max()
    numbers = [squarings_needed(rates, dt) for dt in (1e-4, 1e-3, 1e-2, 0.05)]
    assert numbers == sorted(numbers)
    for squarings, dt in zip(numbers, (1e-4, 1e-3, 1e-2, 0.05), strict=True):
        assert fastest * dt / 2**squarings < LONGEST_PHASE
    rates[loop.size // 2 :] *= 1e9
    assert squarings_needed(rates, 0.01) == MOST_SQUARINGS
