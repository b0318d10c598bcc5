"""The question of a drive, its answer beside the truth, levels by name, and the picture of the score."""

from dataclasses import replace

import numpy as np
import pytest

from jawenv.base.errors import InputError
from jawenv.live import panels
from jawenv.live.levels import GAME, OWN, level_of
from jawenv.live.outcome import LEARNED, learned_agents, outcomes_of_rivals
from jawenv.live.page import Page
from jawenv.live.question import answered, stiff_from_N, stiffness_colours
from jawenv.live.score_card import score_png
from jawenv.live.server import serving
from jawenv.live.session import DriveSession
from jawenv.live.setup import Setup
from jawenv.rendering import palette


@pytest.fixture(scope="module")
def shown():
    return DriveSession(Setup.of(seed=500, episode_s=1.0, cohort="one_sided")).drive([0.3, 0.1, 0.0, 0.0])


def test_an_answer_is_right_where_it_is_the_truth(shown):
    scene = shown.scene
    forces = np.exp(scene.truth[::2])
    truth = (forces > 1.7).tolist()
    assert sum(truth) == 3  # one side
    rows = answered(scene, truth)
    assert all(row.right for row in rows) and [row.muscle for row in rows] == list(scene.muscles)
    np.testing.assert_allclose([row.true_F_o_N for row in rows], forces)
    np.testing.assert_allclose([row.sd for row in rows], scene.belief_sd[::2])
    html = panels.answer_html(answered(scene, [True] * 6))
    assert "3 of 6 right" in html and "above 1.7 N" in html and html.count("healthy") == 3
    assert answered(replace(scene, truth=None), truth) == []


def test_muscles_together_are_stiff_from_their_forces_together():
    scene = DriveSession(Setup.of(seed=500, episode_s=1.0, model="hinge")).shown().scene
    assert stiff_from_N(scene) == pytest.approx(6 * 1.7)


def test_the_colour_of_stiffness_is_green_below_the_limit_and_clay_above(shown):
    forces = np.where(np.arange(12) % 2 == 0, np.log(1.7 / 3), 0.0)
    forces[0] = np.log(1.7 * 9)
    colours = stiffness_colours(replace(shown.scene, belief_mean=forces))
    assert colours[0] == palette.KNOWLEDGE[0] and set(colours[1:]) == {palette.GOOD}
    assert panels.legend_html(shown.scene, True) != panels.legend_html(shown.scene)


def test_levels_are_recognised_by_cohort_and_knowledge():
    for level in GAME:
        assert level_of(Setup.of(cohort=level.cohort, knowledge=level.knowledge)) is level
    assert level_of(Setup.of(cohort="severe")) is OWN


def test_the_picture_of_a_score_grows_with_what_is_on_it(shown):
    answer = answered(shown.scene, [True] * 6)
    sizes = []
    for rows in (answer, []):
        picture = score_png("patchy", rows, [shown.outcome])
        assert picture.startswith(b"\x89PNG\r\n\x1a\n")
        sizes.append(int.from_bytes(picture[20:24], "big"))
    assert sizes[0] == sizes[1] + 8 * 30  # head, six muscles, a gap


def test_learned_agents_are_rivals_where_they_can_play():
    short = {"seed": 500, "episode_s": 1.0}
    assert [one.name for one in outcomes_of_rivals(Setup.of(**short), learned_agents(), ())] == list(LEARNED)
    assert outcomes_of_rivals(Setup.of(**short, model="sides"), learned_agents(), ()) == []


def test_the_easy_level_hides_its_bars_at_first_and_asks_at_the_end(tmp_path):
    with serving(0) as server:
        page = Page(server, Setup.of(seed=500, episode_s=1.0, cohort="one_sided"), tmp_path, driver="apg_anyone")
        page.step()
        assert "hidden" in page._view._posterior.content and page._view._strip.content == ""
        assert page._question._folder is None
        while not page.session.ended:
            page.step()
        assert "your answer" in page._view._posterior.content and page._picture.visible
        names = [box.label for box in page._question._boxes]
        assert names[0] == "masseter left" and len(names) == 6
        page._question._boxes[0].value = True
        page._question._take()
        assert "of 6 right" in page._question._card.content and page._question._folder is None
        assert "known" in page._view._posterior.content
        assert [row.said for row in page._question.answer] == [True] + 5 * [False]
        page._fulfil(page._choices.next_patient)
        assert page.session.setup.seed == 501 and page._question.answer == []
        page._choices._level.value = "anyone"
        page._fulfil(page._choices._choose_level)
        assert level_of(page.session.setup).title == "anyone" and page._hidden_s == 0.0
        page.step()
        assert "known" in page._view._posterior.content
        with pytest.raises(InputError):
            page.session.hand_over("nobody")


def test_the_limit_that_costs_is_named(shown):
    assert "allowed" in panels.status_html(shown)
    names = shown.scene.comfort
    costly = replace(shown, scene=replace(shown.scene, comfort=dict.fromkeys(names, 0.5) | {"fore_aft": 1.2}))
    assert "fore-aft" in panels.status_html(costly) and "allowed" not in panels.status_html(costly)
