"""Scar, openers and lateral pterygoids, against the same lines in plain NumPy."""

import newton_euler as twin
import numpy as np
import pytest

from jawenv.reality import Reality
from jawenv.reality.joint import INSERTION, ORIGIN, OTHER_B, SCAR_ONSET, SCAR_SLACK, bands_push

OPEN = np.array([6e-3, 1e-3, 0.28, 0.03, -0.05])


def lengths(jaw, q):
    """Length of each line (5,), and its direction to the origin (5, 3), head axes."""
    lines = ORIGIN - (twin.contact(jaw, q) + INSERTION @ twin.rotation(q).T)
    length = np.linalg.norm(lines, axis=1)
    return length, lines / length[:, None]


def push(jaw, q, **options):
    return np.array(bands_push(Reality(**options).records()[0], jaw, tuple(q), (0.0, 0.0)))


def wrench(jaw, q, tensions):
    """Independent: force and moment of the lines' tensions at the mouthpiece, body axes."""
    forces = tensions[:, None] * lengths(jaw, q)[1] @ twin.rotation(q)
    return np.concatenate([forces.sum(axis=0), np.cross(INSERTION - jaw["mouthpiece"], forces).sum(axis=0)])


def test_a_scar_is_slack_at_rest_and_pulls_on_one_side_when_the_jaw_opens(jaw):
    assert not push(jaw, np.zeros(5), scar_stiffness_N_m=1000.0).any()
    longer = lengths(jaw, OPEN)[0][0] - SCAR_SLACK * lengths(jaw, np.zeros(5))[0][0]
    assert longer > SCAR_ONSET
    tension = np.array([1000.0 * (longer - 0.5 * SCAR_ONSET), 0.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(push(jaw, OPEN, scar_stiffness_N_m=1000.0), wrench(jaw, OPEN, tension), atol=1e-12)


@pytest.mark.parametrize("q", [np.zeros(5), OPEN])
def test_the_other_muscles_have_the_closers_law(jaw, q):
    closed, length = lengths(jaw, np.zeros(5))[0], lengths(jaw, q)[0]
    tension = 0.3 * np.exp(OTHER_B * (length / closed - 1.0))
    tension[0] = 0.0
    np.testing.assert_allclose(push(jaw, q, other_muscles_F_o_N=0.3), wrench(jaw, q, tension), atol=1e-12)


def test_the_other_muscles_of_a_symmetric_pose_neither_push_aside_nor_roll(jaw):
    pose = np.array([5e-3, 0.0, 0.2, 0.0, 0.0])
    np.testing.assert_allclose(push(jaw, pose, other_muscles_F_o_N=0.3)[[1, 3, 5]], 0.0, atol=1e-15)
