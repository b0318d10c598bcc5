"""Colours by stiffness, learned rivals, and the limit that costs."""

from dataclasses import replace

import numpy as np
import pytest

from jawenv.live import panels
from jawenv.live.outcome import LEARNED, learned_agents, outcomes_of_rivals
from jawenv.live.session import DriveSession
from jawenv.live.setup import Setup
from jawenv.live.stiffness import stiff_from_N, stiffness_colours
from jawenv.rendering import palette


@pytest.fixture(scope="module")
def shown():
    return DriveSession(Setup.of(seed=500, episode_s=1.0, cohort="one_sided")).drive([0.3, 0.1, 0.0, 0.0])


def test_muscles_together_are_stiff_from_their_forces_together():
    scene = DriveSession(Setup.of(seed=500, episode_s=1.0, model="hinge")).shown().scene
    assert stiff_from_N(scene) == pytest.approx(6 * 1.7)


def test_the_colour_of_stiffness_is_green_below_the_limit_and_clay_above(shown):
    forces = np.where(np.arange(12) % 2 == 0, np.log(1.7 / 3), 0.0)
    forces[0] = np.log(1.7 * 9)
    colours = stiffness_colours(replace(shown.scene, belief_mean=forces))
    assert colours[0] == palette.KNOWLEDGE[0] and set(colours[1:]) == {palette.GOOD}
    assert panels.legend_html(shown.scene, True) != panels.legend_html(shown.scene)


def test_learned_agents_are_rivals_where_they_can_play():
    short = {"seed": 500, "episode_s": 1.0}
    assert [one.name for one in outcomes_of_rivals(Setup.of(**short), learned_agents(), ())] == list(LEARNED)
    assert outcomes_of_rivals(Setup.of(**short, model="sides"), learned_agents(), ()) == []


def test_the_limit_that_costs_is_named(shown):
    assert "allowed" in panels.status_html(shown)
    names = shown.scene.comfort
    costly = replace(shown, scene=replace(shown.scene, comfort=dict.fromkeys(names, 0.5) | {"fore_aft": 1.2}))
    assert "fore-aft" in panels.status_html(costly) and "allowed" not in panels.status_html(costly)
