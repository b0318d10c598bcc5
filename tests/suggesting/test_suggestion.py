"""What to record next: made for the patient, expected honestly, and refused where the recording is."""

import re
from dataclasses import replace

import numpy as np
import pytest

import jawenv
from jawenv.base.errors import InputError
from jawenv.commands.app import main
from jawenv.playing.maneuvers import Maneuver
from jawenv.recordings.files import load_record, save_record
from jawenv.suggesting.lead import led_back
from jawenv.suggesting.suggestion import suggest

PLAYED = {"cohort": "one_sided", "episode_s": 10.0, "record": True, "track_bound": False}


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("next") / "recording.csv"
    played = jawenv.play(jawenv.Player("opening_with_swings"), patients=1, seed=5600, env_kwargs=PLAYED)
    save_record(played.records[0], path)
    return path


def test_the_next_movement_is_a_maneuver_that_tells_more_than_the_same_again(recording, tmp_path, capsys):
    output = tmp_path / "next.yaml"
    assert main(["suggest", str(recording), "-o", str(output)]) == 0
    said = capsys.readouterr().out
    assert "least known now: " in said and "next: opens to " in said and "in its place: the same again" in said
    assert "; before it the jaw is led back to rest, 2" in said
    written = Maneuver.load(output)
    assert written.channels.side is not None and written.channels.opening.points[-1].t_s > 10.5
    assert main(["suggest", str(recording), "-o", str(output)]) == 2
    assert "exists already" in capsys.readouterr().err
    assert main(["suggest", str(recording), "-o", str(tmp_path / "next.txt")]) == 2
    assert "ends in .yaml" in capsys.readouterr().err


@pytest.fixture(scope="module")
def found(recording):
    return suggest(load_record(recording), 6.0)


def test_only_from_a_recording_that_ends_open_the_jaw_is_led_back(recording, found):
    record = load_record(recording)
    closed = replace(record, measured=np.vstack([record.measured[:-10], record.measured[:10]]))
    one = closed.measured.copy()
    one[:, 1] = np.nan
    for at_rest in (closed, replace(closed, measured=one), replace(closed, measured=record.measured[::-1])):
        assert led_back(at_rest, found) == (found.maneuver, "")
    maneuver, words = led_back(record, found)
    open_all_along = replace(record, measured=np.tile(record.measured[-1], (len(record.measured), 1)))
    also = led_back(open_all_along, found)[0].targets(np.array([0.2])).value
    np.testing.assert_allclose(also[0, 0], maneuver.targets(np.array([0.2])).value[0, 0], atol=0.02)
    lasts_s = float(re.search(r"led back to rest, \d+ mm in ([0-9.]+) s", words)[1])
    held = Maneuver.named("opening_with_swings").targets(np.array([10.0])).value[0]
    led = maneuver.targets(np.arange(0.2, lasts_s + 0.1, 0.2)).value
    np.testing.assert_allclose(led[0, :2], held[:2], atol=0.15)  # where the recording ends
    assert (led[-1] == 0.0).all() and np.abs(np.diff(led[:, 0])).max() <= 0.1 + 1e-9
    times = np.arange(0.2, 6.1, 0.2)
    np.testing.assert_allclose(maneuver.targets(lasts_s + times).value, found.maneuver.targets(times).value, atol=1e-4)


def test_what_is_expected_is_below_what_is_known_and_the_same_again(found):
    assert found.seconds == pytest.approx(6.0)
    assert found.expected.low <= found.expected.median <= found.expected.high < found.worst_sd
    assert found.expected.median < found.again < found.worst_sd
    assert found.expected.discomfort_s < 0.05


def test_other_lengths_and_recordings_that_are_not_believed_are_refused(recording):
    record = load_record(recording)
    for seconds in (0.0, np.nan, 100.0):
        with pytest.raises(InputError, match="seconds is"):
            suggest(record, seconds)
    spoilt = replace(record, samples=-record.samples)
    with pytest.raises(InputError, match="not to be believed"):
        suggest(spoilt)


def test_a_search_is_suggested_only_where_more_is_expected_of_it(recording):
    record = load_record(recording)
    plain, searched = suggest(record, 2.0), suggest(record, 2.0, search=1)
    assert searched.expected.median <= plain.expected.median
    with pytest.raises(InputError, match="search is -1"):
        suggest(record, 2.0, search=-1)


def test_a_question_makes_another_movement_and_counts_its_muscle_alone(recording):
    record = load_record(recording)
    asked, every = suggest(record, 2.0, asked="masseter_left"), suggest(record, 2.0)
    assert asked.worst_sd < every.worst_sd
    assert asked.maneuver.channels != every.maneuver.channels
    for wrong in ("tongue", "random"):
        with pytest.raises(InputError, match="asked is"):
            suggest(record, asked=wrong)
