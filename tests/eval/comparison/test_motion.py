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
        (moved,) = watched(["chirp"], settings).motions.values()
        times = moved["frames"]["time_s"]
        assert len(times) == steps
        assert np.diff(times) == pytest.approx(2.0 / steps)


def test_an_opening_opens_and_who_is_held_stays(study):
    opening, held = (np.array(study.motions[name]["frames"]["moved"])[:, 0] for name in ("slow_opening", "hold_still"))
    assert opening[-1] - opening[0] > 0.4
    assert abs(held[-1] - held[0]) < 0.2
    sd = np.array(study.motions["slow_opening"]["frames"]["sd"])
    assert sd.shape == (10, 12)
    assert (sd[-1] <= sd[0]).all()


def test_frames_put_the_mouthpiece_where_it_is_said_to_be(study):
    """Contact point and turn give the opening that stands beside them, to the four digits that are kept."""
    from scipy.spatial.transform import Rotation

    moved = study.motions["slow_opening"]
    frames = moved["frames"]
    turned = Rotation.from_rotvec(frames["turn"]).apply(moved["mouthpiece"])
    opening = moved["mouthpiece"][2] - (np.array(frames["contact"]) + turned)[:, 2]
    assert opening == pytest.approx(np.array(frames["moved"])[:, 0], abs=0.05)
