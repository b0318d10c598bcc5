"""Films are drawn by the renderer from the scenes that were kept."""

import base64

from eval.comparison.ranking import rank
from eval.report import films
from tests.eval.studies import many_entries
from tests.rendering.jaw_scenes import scene


def test_a_film_has_its_pictures_and_ends_with_the_episode():
    film = films._film([scene(opening=0.02 * step, time_s=0.2 * step) for step in range(6)])
    assert base64.b64decode(film)[4:8] == b"ftyp"
    assert base64.b64decode(films._film([scene()]))[4:8] == b"ftyp"


def test_the_best_and_what_it_stands_beside_are_filmed():
    made = many_entries()
    study = type(made)(made.patients, made.curves, made.about, {f"no_{k}": [scene()] for k in range(1, 12)})
    assert [row.entry for row in films.filmed(study, rank(study))] == ["no_1", "no_2", "no_3", "no_4"]
