"""Films are drawn by the renderer from the motions that were kept."""

import base64
from dataclasses import fields

import numpy as np
import pytest

from eval.comparison.motion import _frame_of, beginning
from eval.comparison.ranking import rank
from eval.report import films
from jawenv.ladder import MODELS
from jawenv.rendering.film import JawRenderer
from tests.eval.studies import many_entries
from tests.rendering.jaw_scenes import differ, scene


def motion(*shown, every_s=0.2):
    made = beginning(shown[0])
    frames = [_frame_of(each) for each in shown]
    made["frames"] = {name: [frame[name] for frame in frames] for name in frames[0]}
    made["frames"]["time_s"] = [every_s * i for i in range(len(shown))]
    return made


@pytest.mark.parametrize("model", MODELS)
def test_a_scene_that_was_kept_is_drawn_as_it_was(model):
    true = scene(opening=0.2, sd=0.04, model=model)
    kept = next(films.scenes(motion(true, true), MODELS[model]))
    drawn = ("contact_m", "rotation", "muscle_insertion_m", "muscle_tension_N", "mouthpiece_m", "belief_cov")
    assert set(drawn) <= {field.name for field in fields(true)}
    for name in drawn:
        np.testing.assert_allclose(getattr(kept, name), getattr(true, name), atol=1e-4)
    renderer = JawRenderer()
    assert differ(renderer.draw(true), renderer.draw(kept), np.s_[58:]) < 400  # of 217,600: four digits are kept


def test_a_film_has_its_pictures_and_ends_with_the_episode():
    shown = [scene(opening=0.02 * step, time_s=0.2 * step) for step in range(6)]
    film = films._film(motion(*shown), MODELS["jaw"])
    assert base64.b64decode(film)[4:8] == b"ftyp"


def test_the_best_what_it_stands_beside_and_what_is_asked_for_are_filmed():
    made = many_entries()
    moved = motion(scene(), scene())
    study = type(made)(made.patients, made.curves, made.about, {f"no_{k}": moved for k in range(1, 12)})
    ranking = rank(study)
    rows = {row.entry: row for row in ranking.rows}
    assert [row.entry for row in films.filmed(study, ranking, ())] == ["no_1", "no_2", "no_3", "no_4"]
    asked = films.filmed(study, ranking, [rows["no_9"], rows["my_own"]])
    assert [row.entry for row in asked] == ["no_1", "no_2", "no_3", "no_9"], "what was not kept cannot be filmed"
    assert len(films.filmed(study, ranking, ranking.rows)) == films.MOST
