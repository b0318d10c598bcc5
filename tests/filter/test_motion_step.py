"""The filter's step against the exponential of an independent Jacobian, and against differences of its own motion."""

import newton_euler as twin
import numpy as np
from numpy_model import fastest_rate, parts_needed, reading_at
from scipy.linalg import expm

import jawenv
from jawenv.filter.model.motion_step import move, step_dtype
from jawenv.mechanics import build_jaw

DT = 0.01
STAGES = (0.0, 0.5, 0.5, 1.0)


def midline_start(rng):
    q = [rng.uniform(1e-3, 8e-3), rng.uniform(-1e-3, 1e-3), rng.uniform(0.1, 0.4), *rng.uniform(-0.05, 0.05, 2)]
    return np.array([*q, *rng.uniform(-0.02, 0.02, 2), *rng.uniform(-0.5, 0.5, 3)])


class Model:
    """The filter's model: its kernel and its independent twin."""

    def __init__(self):
        self.jaw, self.n = build_jaw(), 10
        self.short = 0.1 * DT  # in which it takes no more parts than it must, nor does half of it
        self.scratch = np.zeros(1, dtype=step_dtype(6, self.n))[0]

    def parts(self, theta, state, dt):
        return parts_needed(fastest_rate(self.jaw, theta, state[:5]), dt)

    def by_kernel(self, theta, state, samples, dt):
        """Motion and derivative (n, n + 6) at the end of a step."""
        moved = state.copy()
        self.scratch["muscles"] = np.exp(theta).reshape(6, 2)
        move(self.jaw, moved, samples, dt, True, self.scratch)
        return moved, self.scratch["total"].copy()

    def path(self, theta, state, samples, dt, parts, wrench=0.0):
        """Motion at the end, and state and wrench in the middle of the step, where the Jacobian is taken."""
        h, middles = dt / parts, []
        for part in range(parts):

            def rate(stage, at, part=part):
                return twin.state_rate(
                    self.jaw, theta, at, reading_at(samples, (part + STAGES[stage]) / parts) + wrench
                )

            slopes = [rate(0, state)]
            for stage, reach in ((1, 0.5 * h), (2, 0.5 * h), (3, h)):
                slopes.append(rate(stage, state + reach * slopes[-1]))
            middle = state + 0.5 * h * slopes[1]
            if part == parts // 2:
                middles = parts * [(middle if parts % 2 else state, reading_at(samples, 0.5))]
            state = state + h / 6.0 * (slopes[0] + 2.0 * slopes[1] + 2.0 * slopes[2] + slopes[3])
        return state, middles

    def frozen(self, theta, middles, dt, exponential=expm):
        """Derivative (n, n + 6) of the system that is frozen there, part by part."""
        total, h = np.eye(self.n, self.n + 6), dt / len(middles)
        for middle in middles:
            both = np.zeros((self.n + 6, self.n + 6))
            both[: self.n] = twin.derivative(
                lambda v: twin.state_rate(self.jaw, theta, v[: self.n], v[self.n :]), np.concatenate(middle)
            )
            whole = exponential(h * both)
            total = whole[: self.n, : self.n] @ total
            total[:, self.n :] += whole[: self.n, self.n :]
        return total


def four_terms(matrix):
    """The exponential's series to the fourth order."""
    powers = [np.linalg.matrix_power(matrix, k) for k in range(5)]
    return powers[0] + powers[1] + powers[2] / 2.0 + powers[3] / 6.0 + powers[4] / 24.0


MIDLINE = Model()


def drawn(rng):
    theta = jawenv.cohort("trismus").draw_log_parameters(rng)
    samples = np.concatenate([rng.uniform(-8, 8, 3), rng.uniform(-0.1, 0.1, 3)])
    return theta, midline_start(rng), samples + rng.normal(size=(3, 6)) * np.repeat([0.5, 0.02], 3)


def scaled(total, h):
    """The derivative in units of metres: angles at a lever of 5 cm, rates over ``h``, wrenches what they move in it."""
    half, lever = MIDLINE.n // 2, 0.05
    units = np.tile(np.repeat([1.0, 1.0 / lever], [half - 3, 3]), 2)
    units[half:] /= h
    mass = float(MIDLINE.jaw["mass"])
    pushes = np.repeat([mass / h**2, mass * lever / h**2], 3)
    return total / units[:, None] * np.concatenate([units, pushes])


def off(actual, expected, dt):
    """Norm of the difference over the norm of what is expected."""
    return np.linalg.norm(scaled(actual - expected, dt), 2) / np.linalg.norm(scaled(expected, dt), 2)


def test_the_motion_alone_is_the_same_to_rounding_and_leaves_no_derivative(rng):
    theta, state, samples = drawn(rng)
    moved, _ = MIDLINE.by_kernel(theta, state, samples, DT)
    alone = state.copy()
    MIDLINE.scratch["total"] = 7.0
    move(MIDLINE.jaw, alone, samples, DT, False, MIDLINE.scratch)
    np.testing.assert_allclose(alone, moved, rtol=1e-12, atol=1e-14)
    np.testing.assert_array_equal(MIDLINE.scratch["total"], 7.0)


def test_the_derivative_is_that_of_the_motion_but_for_the_frozen_jacobian(rng):
    """By the complex step through Runge and Kutta's motion; half the step makes less than half of the error."""
    wrong = {MIDLINE.short: [], 0.5 * MIDLINE.short: []}
    for _ in range(8):
        theta, state, samples = drawn(rng)
        for dt, errors in wrong.items():
            parts = MIDLINE.parts(theta, state, dt)
            exact = twin.derivative(
                lambda v, given=(samples, dt, parts), theta=theta: MIDLINE.path(
                    theta, v[: MIDLINE.n], *given, v[MIDLINE.n :]
                )[0],
                np.concatenate([state, np.zeros(6)]),
            )
            errors.append(off(MIDLINE.by_kernel(theta, state, samples, dt)[1], exact, dt))
    first, second = (np.array(errors) for errors in wrong.values())
    assert first.max() < 0.1
    assert np.median(second) < 0.5 * np.median(first)


def test_parts_of_a_stiff_jaw_are_put_together(rng):
    """On the teeth, where the midline model divides its step: the same product of exponentials."""
    divisions = set()
    for _ in range(20):
        theta, state, samples = drawn(rng)
        state[0], state[2] = rng.choice([-0.7e-3, -0.2e-3, MIDLINE.jaw["crest"] + 0.3e-3]), rng.uniform(-0.02, 0.005)
        parts = MIDLINE.parts(theta, state, DT)
        moved, total = MIDLINE.by_kernel(theta, state, samples, DT)
        end, middles = MIDLINE.path(theta, state, samples, DT, parts)
        np.testing.assert_allclose(moved, end, rtol=1e-9, atol=1e-11)
        assert off(total, MIDLINE.frozen(theta, middles, DT, four_terms), DT) < 1e-8
        assert off(total, MIDLINE.frozen(theta, middles, DT), DT) < 0.06
        divisions.add(parts)
    assert len(divisions) > 1 and max(divisions) > 2


def test_held_coordinates_stay(rng):
    """A hinge's derivative has neither rows nor columns for what is held but the identity."""
    jaw = build_jaw(free=(False, False, True, False, False))
    scratch = np.zeros(1, dtype=step_dtype(6, 10))[0]
    theta = jawenv.cohort("trismus").draw_log_parameters(rng)
    scratch["muscles"] = np.exp(theta).reshape(6, 2)
    state = np.zeros(10)
    state[2], state[8] = 0.2, 0.3
    move(jaw, state, rng.normal(size=(3, 6)), DT, True, scratch)
    held = [0, 1, 3, 4, 5, 6, 7, 9]
    np.testing.assert_array_equal(state[held], 0.0)
    np.testing.assert_array_equal(scratch["total"][np.ix_([5, 6, 7, 9], range(16))], np.eye(10, 16)[[5, 6, 7, 9]])
    assert state[2] != 0.2 and np.abs(scratch["total"][8, 13:]).max() > 0.0
