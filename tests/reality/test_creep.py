"""Creep against its closed form: what relaxes, how fast, how far, and what a jaw does after it was held."""

import numpy as np
import pytest
from reality_states import ON_PATH, REST, STILL, TICK, Tissue, drawn_muscles, tensions

from jawenv.device.motors import mouthpiece_motion
from jawenv.mechanics.dynamics import linear_dtype
from jawenv.mechanics.equilibrium import settle
from jawenv.mechanics.kinematics import rotation

OPEN = (6e-3, 0.2e-3, 0.3, 0.01, -0.02)
SHARE, TIME = 0.3, 2.0


def test_released_tissue_recovers_and_rest_itself_does_not_creep(jaw, rng):
    muscles = drawn_muscles(rng)
    tissue = Tissue(jaw, muscles, creep_share=SHARE, creep_time_s=TIME)
    for _ in range(100):
        np.testing.assert_allclose(tissue.tick(REST), tensions(jaw, muscles, REST), rtol=1e-14)
    for _ in range(3000):
        tissue.tick(OPEN)
    lengthened = tissue.state["creep"].copy()
    for _ in range(round(TIME / TICK)):
        tissue.tick(REST)
    np.testing.assert_allclose(tissue.state["creep"], lengthened * np.exp(-1.0), rtol=1e-10, atol=1e-14)


def test_slack_tissue_does_not_shorten(jaw, rng):
    tissue = Tissue(jaw, drawn_muscles(rng), rest=OPEN, creep_share=SHARE)
    for _ in range(10):
        tissue.tick(REST)
    assert np.all(tissue.state["creep"] == 0.0)


@pytest.mark.parametrize(("share", "shift"), [(0.2, 0.61e-3), (0.5, 1.51e-3)])
def test_a_jaw_held_10_mm_aside_comes_to_rest_aside(jaw, share, shift):
    """The shifts from which the plausible shares are concluded; measured ones are 0.7 to 1.8 mm (Rugh et al. 1990)."""
    muscles = np.tile([0.7, 7.0], (6, 1))  # healthy, as those who were measured
    rest = settled(jaw, muscles, np.array([3e-3, 0.0, 0.05, 0.0, 0.0]))
    tissue = Tissue(jaw, muscles, rest=tuple(rest), creep_share=share)
    held = rest.copy()
    held[3] = np.arcsin(10e-3 / jaw["mouthpiece"][0])
    for _ in range(round(10.0 / TICK)):
        tissue.tick(held)
    after = settled(jaw, tissue.effective, rest)
    assert side(jaw, after) - side(jaw, rest) == pytest.approx(shift, abs=0.03e-3)


def settled(jaw, muscles, pose):
    state = np.concatenate([pose, np.zeros(5)])
    scratch = np.zeros(1, dtype=linear_dtype(6))[0]
    _, found = settle(jaw, muscles, state, 0.0, False, scratch, np.zeros((5, 5)), np.zeros(5))
    assert found
    return state[:5]


def side(jaw, pose):
    q = tuple(pose)
    return mouthpiece_motion(jaw, q, STILL, ON_PATH, rotation(q))[0][1]
