import numpy as np
import pytest
from rich.console import Console

from eval.comparison.motion import play_patient
from eval.comparison.results import compare
from eval.kept.entries import Settings, load_entries


def watched(specs, settings):
    return play_patient(compare(load_entries(specs, settings.world), settings), specs, Console(quiet=True))


@pytest.fixture(scope="module")
def study():
    settings = Settings.of(patients=2, control="targets", episode_s=2.0)
    return watched(["slow_opening", "hold_still"], settings)


def test_the_first_patient_is_watched_at_most_ten_times_a_second(study):
    for control, steps in (("targets", 10), ("force", 20)):
        settings = Settings.of(patients=1, control=control, episode_s=2.0)
        (scenes,) = watched(["chirp"], settings).motions.values()
        assert len(scenes) == steps
        assert np.diff([scene.time_s for scene in scenes]) == pytest.approx(2.0 / steps)


def test_an_opening_opens_and_who_is_held_stays(study):
    opening, held = ([scene.opening_mm for scene in study.motions[name]] for name in ("slow_opening", "hold_still"))
    assert opening[-1] - opening[0] > 0.4
    assert abs(held[-1] - held[0]) < 0.2
    first, *_, last = study.motions["slow_opening"]
    assert (last.belief_sd <= first.belief_sd).all()
