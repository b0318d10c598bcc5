"""The joint's stiffness near the end of opening: where it begins, how it grows, which way it pushes."""

import newton_euler as twin
import numpy as np
import pytest

from jawenv.device.comfort import limits_dtype
from jawenv.reality import Reality
from jawenv.reality.joint import articular_force, articular_push

REST_OPENING, RANGE, ONSET, STIFFNESS = 0.004, 0.020, 0.8, 3000.0
SIDE = 0.008


@pytest.fixture
def limits():
    record = np.zeros(1, dtype=limits_dtype(6))[0]
    record["rest_opening"], record["opening"], record["side"] = REST_OPENING, RANGE, SIDE
    return record


def lift(jaw, limits, opening, **options):
    """Upward force with the mouthpiece ``opening`` above rest."""
    reality = Reality(articular_stiffness_N_m=STIFFNESS, **options).records()[0]
    place = (0.09, 0.001, jaw["mouthpiece"][2] - REST_OPENING - opening)
    forward, left, up = articular_force(reality, limits, jaw, place)
    assert forward == left == 0.0
    return up


def test_nothing_below_the_onset(jaw, limits):
    for share in (-0.5, 0.0, 0.5, 0.79999):
        assert lift(jaw, limits, share * RANGE) == 0.0


def test_quadratic_to_the_end_of_the_painless_range_then_linear(jaw, limits):
    width = (1 - ONSET) * RANGE
    for share in (0.1, 0.5, 1.0):
        depth = share * width
        assert lift(jaw, limits, ONSET * RANGE + depth) == pytest.approx(STIFFNESS * depth**2 / (2 * width))
    assert lift(jaw, limits, RANGE + 0.003) == pytest.approx(STIFFNESS * (width / 2 + 0.003))


@pytest.mark.parametrize("onset", [0.0, 0.5, 0.95])
def test_force_and_slope_are_continuous(jaw, limits, onset):
    openings = np.linspace(-0.005, 0.03, 4001)
    step = openings[1] - openings[0]
    slope = np.diff([lift(jaw, limits, opening, articular_onset=onset) for opening in openings]) / step
    assert np.all(np.abs(np.diff(slope)) <= STIFFNESS * step / ((1 - onset) * RANGE) * (1 + 1e-6))
    assert slope[0] == 0.0 and slope[-1] == pytest.approx(STIFFNESS)


def test_the_push_on_the_body_is_the_force_turned(jaw, limits):
    q = np.array([6e-3, 1e-3, 0.28, 0.03, -0.05])
    place = twin.contact(jaw, q) + twin.rotation(q) @ jaw["mouthpiece"]
    reality = Reality(articular_stiffness_N_m=STIFFNESS).records()[0]
    push = np.array(articular_push(reality, limits, jaw, tuple(q), (0.5e-3, 0.0)))
    up = lift(jaw, limits, jaw["mouthpiece"][2] - place[2] - 0.5e-3 - REST_OPENING)
    assert up > 1.0
    np.testing.assert_allclose(twin.rotation(q) @ push, [0, 0, up], atol=1e-12)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_ligaments_push_to_the_middle_from_the_onset_on(jaw, limits, sign):
    reality = Reality(articular_side_stiffness_N_m=STIFFNESS).records()[0]
    for share, ramp in ((0.79, 0.0), (0.9, 0.5 * 0.25), (1.0, 0.5)):
        place = (0.09, sign * share * SIDE, jaw["mouthpiece"][2] - REST_OPENING)
        force = np.array(articular_force(reality, limits, jaw, place))
        expected = [0.0, -sign * STIFFNESS * ramp * (1 - ONSET) * SIDE, 0.0]
        np.testing.assert_allclose(force, expected, atol=1e-12)
