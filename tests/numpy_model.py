"""One step of the filters' model and its derivative in plain NumPy: shares no compiled code with ``joint_step``.

The mechanics are those of ``newton_euler``, the derivative is taken by the complex step (Squire &
Trapp 1998), all columns at once. It is exact to rounding and verifies the kernels; it is hundreds of times slower.
"""

import newton_euler
import numpy as np
from newton_euler import IMAGINARY_STEP

from jawenv.filter.model.motion_step import N_NOISE
from jawenv.filter.readings.cell_trend import TREND_TIME
from jawenv.mechanics.dynamics import N_STATES, N_WRENCH
from jawenv.mechanics.stiffness import LARGEST_PHASE, MOST_PARTS


def _with_derivative(function, point):
    """Value (m,) of a function at the point (n,), and its derivative (m, n) by complex step.

    Args:
        function: maps (n, n) points, one in a row, to (n, m) values.
        point: (n,).
    """
    values = function(point + 1j * IMAGINARY_STEP * np.eye(len(point)))
    return values[0].real.copy(), values.imag.T / IMAGINARY_STEP


def fastest_rate(jaw, log_parameters, q):
    """Bound on the angular frequency (rad/s) of the jaw's free motion, by the rule of ``jawenv.mechanics.stiffness``.

    Args:
        jaw: record of dtype ``jaw_dtype``.
        log_parameters: (..., 2 m) natural logs of F_o (N) and b.
        q: (..., 5) coordinates; of several poses the largest bound is returned.
    """
    b = np.exp(log_parameters)[..., 2 * jaw["muscle"] + 1]
    line_terms = newton_euler.tensions(jaw, log_parameters, q) * b / jaw["l_o"] * jaw["mobility"]
    width, teeth = jaw["stop_width"], jaw["teeth"]
    positions = newton_euler.contact(jaw, q)[..., None, :] + teeth @ newton_euler.transposed(newton_euler.rotation(q))
    # A stop's force per stiffness has the slope 0 before it is touched, 1 once its onset is passed.
    tooth_contact = np.clip((positions[..., 2] - teeth[:, 2]) / width, 0.0, 1.0)
    tooth_terms = tooth_contact * jaw["tooth_stiffness"] * jaw["tooth_mobility"]
    x, crest = q[..., 0], np.pi / jaw["fossa_frequency"]
    stop_contact = np.clip(-x / width, 0.0, 1.0) + np.clip((x - crest) / width, 0.0, 1.0)
    capsule_term = stop_contact * jaw["condyle_stiffness"] * jaw["condyle_mobility"]
    return float(np.sqrt(line_terms.sum(axis=-1) + tooth_terms.sum(axis=-1) + capsule_term).max())


def parts_needed(rate, dt):
    """Least number of parts of ``dt`` (s) in each of which the phase of ``rate`` (rad/s) is short."""
    shares = max(rate * dt / LARGEST_PHASE, 1.0)
    return int(min(np.ceil(shares), MOST_PARTS))


def reading_at(samples, share):
    """The load cell (6,) at a share of the step: Lagrange's parabola through its samples (3, 6) at 0, 1/2 and 1."""
    weights = [2.0 * (share - 0.5) * (share - 1.0), -4.0 * share * (share - 1.0), 2.0 * share * (share - 0.5)]
    return np.array(weights) @ samples


def step(jaw, mean, samples, trend, dt, wrench=None):
    """Motion at the end of a step.

    Args:
        jaw: record of dtype ``jaw_dtype`` of a midline model.
        mean: (..., 10 + p + 1) motion q and u, natural-log parameters, gain error of the load cell; complex or not. All
            are stepped in as many parts as the stiffest of them needs.
        samples: (3, 6) of the load cell at the start, the middle and the end of the step (N, N m).
        trend: (6,) recent trend of its readings.
        dt: s.
        wrench: (..., 12) that the load cell does not read: constant over the step, and what it grows by until its end.

    Returns:
        (..., 10).
    """
    motion, parameters, gain = mean[..., :N_STATES], mean[..., N_STATES:-1], mean[..., -1:]
    wrench = np.zeros(N_NOISE) if wrench is None else wrench
    level, growth = wrench[..., :N_WRENCH], wrench[..., N_WRENCH:]
    parts = parts_needed(fastest_rate(jaw, parameters.real, motion[..., :5].real), dt)
    for part in range(parts):

        def rate(since, state, part=part):
            share = part / parts + since / dt
            unread = level + (2.0 * share - 1.0) * growth
            return newton_euler.state_rate(jaw, parameters, state, reading_at(samples, share) + gain * trend + unread)

        motion = newton_euler.runge_kutta(rate, motion, dt / parts)
    return motion


def step_with_derivative(jaw, mean, samples, trend, dt):
    """Motion (10,) at the end of a step, and its derivative (10, 10 + p + 1 + 12).

    The columns are motion, natural-log parameters, gain error, and the wrench that is not read: constant over the step,
    and tilting from -1 to 1. Arguments as of ``step``, of one state.
    """

    def moved(points):
        return step(jaw, points[..., :-N_NOISE], samples, trend, dt, points[..., -N_NOISE:])

    return _with_derivative(moved, np.concatenate([mean, np.zeros(N_NOISE)]))


def measurement_with_derivative(jaw, state):
    """The readings (12,) to expect of a motion (10,), and their derivative (12, 10)."""
    return _with_derivative(lambda states: newton_euler.measurement(jaw, states), state)


def mean_readings(record):
    """(T, 6) the load cell's mean over each tick, by Simpson's rule."""
    samples = record.samples
    return (samples[:, 0] + 4.0 * samples[:, 1] + samples[:, 2]) / 6.0


def trends(record):
    """(T, 6) trend of the load cell at the start of each tick, by the law of ``cell_trend.follow_trend``."""
    follow, means = -np.expm1(-record.dt / TREND_TIME), mean_readings(record)
    rows = np.zeros_like(means)
    for k in range(len(rows) - 1):
        rows[k + 1] = rows[k] + follow * (means[k] - rows[k])
    return rows
