"""Where the relaxed jaw rests, and how far a force opens it."""

import newton_euler as twin
import numpy as np
import pytest
from scipy.optimize import brentq

import jawenv
from jawenv.base.errors import InputError
from jawenv.mechanics.dynamics import linear_dtype
from jawenv.mechanics.equilibrium import settle
from tests.passive_opening import passive_opening, pull_to_open

CLOSED = (3e-3, 0.0, 0.05, 0.0, 0.0)


def all_muscles(F_o, b=7.0):
    return np.log(np.tile([F_o, b], 6))


def settled(jaw, log_parameters, opening=None, pose=CLOSED):
    """Pose (5) and downward force (N) at equilibrium, free or held on the vertical spring."""
    pose = np.array(pose)
    force, found = settle(
        jaw,
        np.exp(log_parameters).reshape(6, 2),
        pose,
        opening or 0.0,
        opening is not None,
        np.zeros(1, dtype=linear_dtype(6))[0],
        np.empty((5, 5)),
        np.empty(5),
    )
    assert found
    return pose, force


def opening_m(jaw, pose):
    return jaw["mouthpiece"][2] - twin.measurement(jaw, np.concatenate([pose, np.zeros(5)]))[2]


def opening_under(jaw, F_o, force):
    """Opening (m) under a downward force, on the branch that starts at rest."""
    log_parameters = all_muscles(F_o)
    rest, _ = settled(jaw, log_parameters)
    spring = brentq(lambda s: settled(jaw, log_parameters, s, rest)[1] - force, opening_m(jaw, rest), 0.035, xtol=1e-7)
    return opening_m(jaw, settled(jaw, log_parameters, spring, rest)[0])


def test_at_rest_nothing_accelerates_and_a_push_dies_away(jaw, rng):
    for name in ("trismus", "healthy", "severe", "one_sided", "blockage"):
        log_parameters = jawenv.cohort(name).draw_log_parameters(rng)
        pose, _ = settled(jaw, log_parameters)
        at_rest = np.concatenate([pose, np.zeros(5)])
        np.testing.assert_allclose(twin.state_rate(jaw, log_parameters, at_rest, np.zeros(6)), 0.0, atol=1e-8)
        flow = twin.derivative(lambda s, p=log_parameters: twin.state_rate(jaw, p, s, np.zeros(6)), at_rest)
        assert np.linalg.eigvals(flow).real.max() < 0.0


def test_held_open_the_spring_carries_the_jaw(jaw, rng):
    log_parameters = jawenv.cohort("trismus").draw_log_parameters(rng)
    rest, _ = settled(jaw, log_parameters)
    pose, force = settled(jaw, log_parameters, opening_m(jaw, rest) + 0.010, rest)
    down = twin.rotation(pose).T @ [0, 0, -force]
    left_over = twin.acceleration(jaw, log_parameters, pose, np.zeros(5), np.concatenate([down, np.zeros(3)]))
    np.testing.assert_allclose(left_over, 0.0, atol=1e-7)
    assert force > 0.0
    assert opening_m(jaw, pose) - opening_m(jaw, rest) == pytest.approx(0.010, abs=force / 20e3 + 1e-9)


def test_equal_sides_rest_in_the_midline(jaw):
    pose, _ = settled(jaw, all_muscles(1.2))
    np.testing.assert_allclose(pose[[1, 3, 4]], 0.0, atol=1e-12)


def test_a_tone_closes_the_jaw_that_hangs_open(jaw):
    held, _ = settled(jaw, all_muscles(0.7))
    jaw["tone"] = 0.0
    hanging, _ = settled(jaw, all_muscles(0.7))
    assert 2.0 < 1e3 * opening_m(jaw, held) < 4.0 < 1e3 * opening_m(jaw, hanging)


def test_openings_under_pulls_are_those_of_an_independent_search(jaw):
    rest, pulled = passive_opening(all_muscles(6.0), (0.0, 15.0))
    assert rest == pytest.approx(1e3 * opening_m(jaw, settled(jaw, all_muscles(6.0))[0]), abs=1e-6)
    assert pulled == pytest.approx(1e3 * opening_under(jaw, 6.0, 15.0), abs=0.05)


def test_stiffer_patients_open_less_and_weak_ones_snap_through(jaw):
    openings = passive_opening([all_muscles(F_o) for F_o in (0.25, 1.2, 4.0)], (5.0, 20.0))
    assert np.all(np.diff(openings, axis=0) < 0.0) and np.all(np.diff(openings, axis=1) >= 0.0)
    assert openings[0, 0] == openings[0, 1]  # nothing holds it any more


def test_a_pull_is_the_one_that_opens_so_far(jaw):
    theta = [all_muscles(F_o) for F_o in (2.5, 4.0)]
    openings = passive_opening(theta, (8.0, 12.0))
    for row, reached in zip(theta, openings, strict=True):
        np.testing.assert_allclose(pull_to_open(row, reached), (8.0, 12.0), atol=0.05)
    assert pull_to_open(all_muscles(0.7), (1.0,)) == 0.0, "it rests further open"
    assert np.diff(pull_to_open(all_muscles(4.0), (20.0, 25.0, 30.0)), 2) > 0.0, "ever stiffer"
    with pytest.raises(InputError, match="^openings_mm is .*; allowed: "):
        pull_to_open(all_muscles(4.0), (-1.0,))


@pytest.mark.parametrize(
    ("theta", "pulls", "field"),
    [
        (np.zeros(11), (0.0,), "theta"),
        (np.full(12, np.nan), (0.0,), "theta"),
        (np.zeros(12), (), "pulls_N"),
        (np.zeros(12), (-1.0,), "pulls_N"),
        (np.zeros(12), (np.nan,), "pulls_N"),
    ],
)
def test_openings_of_no_patient_or_no_pull_are_refused(theta, pulls, field):
    with pytest.raises(InputError, match=f"^{field} is .*; allowed: "):
        passive_opening(theta, pulls)
