"""Maneuvers written from targets: what is played is what was written, and points on a line are left out."""

import numpy as np
import pytest

from jawenv.base.errors import InputError
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.maneuvers.written import maneuver_of_targets, save_maneuver

HEADER = {"name": "next", "title": "Next", "description": "d", "source": "s"}


def test_targets_are_reached_at_the_ends_of_the_steps_also_from_the_file(tmp_path):
    targets = np.cumsum(np.random.default_rng(0).uniform(-0.05, 0.06, (20, 4)), axis=0).clip(0.0, 1.0)
    maneuver = maneuver_of_targets(targets, 0.2, HEADER)
    again = Maneuver.load(save_maneuver(maneuver, tmp_path / "next.yaml"))
    np.testing.assert_allclose(again.targets(0.2 * np.arange(1, 21)).value, targets, atol=1e-5)


def test_points_on_a_line_are_left_out():
    line = np.linspace(0.02, 0.4, 20)[:, None] * np.ones(4)
    assert len(maneuver_of_targets(line, 0.2, HEADER).channels.opening.points) == 2


def test_another_ending_is_refused(tmp_path):
    maneuver = maneuver_of_targets(np.zeros((2, 4)), 0.2, HEADER)
    with pytest.raises(InputError, match="allowed: a file that ends in .yaml"):
        save_maneuver(maneuver, tmp_path / "next.json")
