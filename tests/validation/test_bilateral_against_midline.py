"""What two condyles on discs change against the midline model, and that nothing else does."""

from itertools import pairwise

import newton_euler as twin
import numpy as np
import pytest
import two_condyles
from bilateral_step import bilateral_step

from jawenv.mechanics import build_jaw
from jawenv.mechanics.bilateral import BODY_STEP, condyle_pressures, put_on_fossa, settle_bilateral
from jawenv.mechanics.dynamics import linear_dtype, state_rate
from jawenv.mechanics.equilibrium import settle
from jawenv.mechanics.kinematics import split_body

MUSCLES = np.tile([1.2, 7.0], (6, 1))
NOTHING = (0.0,) * 6
STIFFER = (1, 4, 16)


def jaw_with_discs(times=1):
    jaw = build_jaw()
    jaw["disc_stiffness"] *= times
    return jaw


def rest_of_both(jaw, wrench=NOTHING):
    """Pose (5) of the midline model at rest, state (12) of the jaw with two condyles at rest under ``wrench``."""
    pose, state = np.array([3e-3, 0.0, 0.05, 0.0, 0.0]), np.empty(12)
    settle(jaw, MUSCLES, pose, 0.0, False, np.zeros(1, dtype=linear_dtype(6))[0], np.empty((5, 5)), np.empty(5))
    put_on_fossa(jaw, pose, state)
    assert settle_bilateral(jaw, MUSCLES, wrench, state, np.empty((6, 6)), np.empty(6))
    return pose, state


def midline_path(jaw, wrench, seconds, every=10e-3, h=2e-3):
    """Mouthpiece's places (m) and angles (rad), every 10 ms, of the midline model under ``wrench(t)``."""
    state, rows, t = np.concatenate([rest_of_both(jaw)[0], np.zeros(5)]), [], 0.0

    def rate(_, s):
        q_rate, u_rate = state_rate(jaw, MUSCLES, tuple(s[:5]), tuple(s[5:]), held)
        return np.array(q_rate + u_rate)

    for _ in range(round(seconds / every)):
        held = wrench(t)
        for _ in range(round(every / h)):
            state = twin.runge_kutta(rate, state, h)
        t += every
        rows.append(np.concatenate([twin.measurement(jaw, state)[:3], state[2:5]]))
    return np.array(rows)


def bilateral_path(jaw, wrench, seconds, every=10e-3, h=BODY_STEP):
    """As ``midline_path``, of the jaw with two condyles, and the pressures (N) on its discs."""
    (_, state), rows, pressures, t = rest_of_both(jaw), [], [], 0.0
    for _ in range(round(seconds / every)):
        held = wrench(t)
        for _ in range(round(every / h)):
            bilateral_step(jaw, MUSCLES, state, held, h)
        t += every
        rows.append(np.concatenate([two_condyles.mouthpiece(jaw, state[:6]), state[3:6]]))
        pressures.append(condyle_pressures(jaw, *split_body(state)))
    return np.array(rows), np.array(pressures)


def opening_force(t, seconds=10.0, most=3.0):
    """A slow pull down, and back: from teeth that touch to 24 mm open."""
    return (0.0, 0.0, -0.5 * most * (1.0 - np.cos(2.0 * np.pi * t / seconds)), 0.0, 0.0, 0.0)


def brought_up(wrench, seconds=1.0):
    """A wrench that rises within ``seconds`` and stays."""
    return lambda t: tuple(min(1.0, t / seconds) * np.array(wrench))


def shaking(t):
    """Forces and moments in every direction, in which a condyle lifts off and comes down again."""
    return (
        np.sin(9 * t),
        2.0 * np.sin(7 * t),
        -3.0 * np.sin(5 * t) ** 2,
        0.1 * np.sin(11 * t),
        0.0,
        0.05 * np.sin(6 * t),
    )


def test_a_symmetric_opening_is_the_midline_models_but_for_the_give_of_the_discs():
    jaw = build_jaw()
    midline = midline_path(jaw, opening_force, 10.0)
    opening = jaw["mouthpiece"][2] - midline[:, 2]
    assert np.ptp(opening) > 20e-3
    apart, largest_force = {}, 0.0
    for times in STIFFER:
        path, pressures = bilateral_path(jaw_with_discs(times), opening_force, 10.0, h=BODY_STEP / times**0.5)
        np.testing.assert_allclose(path[:, [1, 4, 5]], 0.0, atol=1e-12)
        np.testing.assert_allclose(pressures[:, 0], pressures[:, 1], rtol=1e-9)
        apart[times] = np.abs(path - midline).max(axis=0)[[0, 2, 3]]
        largest_force = max(largest_force, pressures.max())
    give = largest_force / build_jaw()["disc_stiffness"]
    assert apart[1][:2].max() < 4 * give < 0.5e-3, "the incisors are farther from the muscles than the condyles"
    assert np.degrees(apart[1][2]) < 0.4
    for soft, stiff in pairwise(STIFFER):
        np.testing.assert_allclose(apart[soft] / apart[stiff], stiff / soft, rtol=0.02)


def test_halving_the_step_changes_nothing_that_matters():
    """While condyles lift off and come down: below 0.15 um and 1e-5 rad, far below the encoders' noise."""
    jaw = build_jaw()
    path, pressures = bilateral_path(jaw, shaking, 5.0)
    halved, _ = bilateral_path(jaw, shaking, 5.0, h=0.5 * BODY_STEP)
    quartered, _ = bilateral_path(jaw, shaking, 5.0, h=0.25 * BODY_STEP)
    assert np.all(np.ptp(path, axis=0) > [0.01, 0.02, 0.02, 0.2, 0.2, 0.1]), "it does shake"
    assert (pressures == 0.0).any()
    first, second = np.abs(path - halved).max(axis=0), np.abs(halved - quartered).max(axis=0)
    assert first[:3].max() < 1.5e-7 and first[3:].max() < 1e-5
    assert second[:3].max() < 0.4 * first[:3].max() and second[3:].max() < 0.4 * first[3:].max()


def test_a_roll_moment_turns_the_jaw_about_its_condyles_not_freely():
    """0.1 N m: one point in the middle lets the jaw roll by 3.5 degrees; two condyles let it roll by a third of it."""
    jaw, wrench = build_jaw(), brought_up((0, 0, 0, 0.1, 0, 0))
    midline, (path, pressures) = midline_path(jaw, wrench, 4.0), bilateral_path(jaw, wrench, 4.0)
    free, resisted = np.degrees(midline[-1, 5]), np.degrees(path[-1, 5])
    assert 3.0 < free < 4.0
    assert 0.8 < resisted < 1.5
    left, right = pressures[-1]
    assert left - right > 1.0, "the discs take the moment"


def test_roll_follows_yaw_since_both_condyles_stay_on_the_slope():
    """A side force of 1 N yaws the jaw: one condyle goes down the eminence, the other up, and so the jaw must roll.

    The midline model knows no such link: it yaws twice as far, moves the incisors 13 instead of 8 mm aside, and rolls
    by what the muscles make of it.
    """
    jaw, wrench = build_jaw(), (0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
    midline = midline_path(jaw, brought_up(wrench), 4.0)
    path, pressures = bilateral_path(jaw, brought_up(wrench), 4.0)
    aside = [1e3 * (rows[-1, 1] - rows[0, 1]) for rows in (midline, path)]
    assert 12 < aside[0] < 14 and 7 < aside[1] < 8.5
    assert midline[-1, 4] > 2 * path[-1, 4] > 0.0
    assert pressures.min() > 0.5, "both condyles stay down"
    _, state = rest_of_both(jaw, wrench)
    (left, _), (right, _) = two_condyles.condyles(jaw, state[:6], np.zeros(6))
    heights = [twin.fossa(jaw, place[0])[0] for place in (left, right)]
    width = 2 * jaw["condyle_half_width"]
    rolled = (heights[0] - heights[1]) / width
    assert rolled > 0.02
    assert left[2] - right[2] == pytest.approx(heights[0] - heights[1], abs=0.05e-3)
    assert path[-1, 5] == pytest.approx(rolled, rel=0.1)


def test_a_large_roll_moment_lifts_one_condyle_off():
    jaw, wrench = build_jaw(), (0.0, 0.0, 0.0, 0.4, 0.0, 0.0)
    path, pressures = bilateral_path(jaw, brought_up(wrench), 4.0)
    assert pressures[0].min() > 1.0
    assert np.all(pressures[-100:, 1] == 0.0) and np.all(pressures[-100:, 0] > 1.0)
    _, state = rest_of_both(jaw, wrench)
    (left, _), (right, _) = two_condyles.condyles(jaw, state[:6], np.zeros(6))
    assert two_condyles.depth(jaw, left) > 0.0 > -0.5e-3 > two_condyles.depth(jaw, right)
    np.testing.assert_allclose(path[-1, 3:], state[3:6], atol=2e-3)
    np.testing.assert_allclose(path[-1, :3], two_condyles.mouthpiece(jaw, state[:6]), atol=0.2e-3)
