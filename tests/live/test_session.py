"""A drive by hand, without any page: what it reaches, what is saved of it, and who drives."""

import numpy as np
import pytest

from eval.kept.entries import load_entries
from jawenv.anatomy.knowledge import IMAGED, Knowledge
from jawenv.base.errors import InputError
from jawenv.live.outcome import DriveOutcome, outcomes_of_rivals
from jawenv.live.playback import Playback
from jawenv.live.session import BY_HAND, DriveSession
from jawenv.live.setup import Setup
from jawenv.playing.maneuvers import Maneuver, Player
from jawenv.recordings.files import load_record
from tests.recorded import BODY

SHORT = Setup.of(seed=500, episode_s=3.0)


def circles(step):
    return [0.5 + 0.4 * np.sin(step / 8), 0.5 * np.sin(step / 5), 0.2 * np.sin(step / 7), 0.1 * np.sin(step / 9)]


@pytest.fixture(scope="module")
def driven():
    session = DriveSession(SHORT)
    step = 0
    while not session.ended:
        shown = session.drive(circles(step))
        step += 1
    return session, shown, step


def test_a_hand_makes_20_steps_a_second_and_learns(driven):
    session, shown, steps = driven
    assert steps == 60 and shown.ended and shown.why == "the time is over" and shown.driver == BY_HAND
    assert shown.outcome.worst_sd == pytest.approx(shown.scene.belief_sd.max())
    assert shown.outcome.worst_sd < 0.3 * shown.scene.prior_sd.max()
    assert shown.outcome.duration_s == pytest.approx(3.0) and not shown.outcome.violated
    assert all(one.force_sd_N < 0.5 * one.force_N for one in session.forces())
    again = session.drive(circles(0))
    assert again.scene.time_s == shown.scene.time_s


@pytest.mark.parametrize("control", ["targets", "trajectory", "force"])
def test_the_hand_opens_the_jaw_in_every_control_mode(control):
    session = DriveSession(Setup.of(seed=500, episode_s=3.0, control=control))
    for _ in range(40):
        shown = session.drive([0.5, 0.0, 0.0, 0.0])
    assert 0.3 < shown.scene.comfort["opening"] < 0.7


def test_a_maneuver_that_drives_is_the_maneuver_and_can_be_taken_over():
    session = DriveSession(SHORT)
    session.hand_over("refined")
    for _ in range(20):
        shown = session.drive([0.0, 0.0, 0.0, 0.0])
    wanted = Maneuver.named("refined").targets(np.array([1.0])).value[0]
    assert shown.driver == "refined"
    np.testing.assert_allclose(shown.targets, wanted)
    session.hand_over(BY_HAND)
    held = session.drive()
    np.testing.assert_allclose(held.targets, np.clip(wanted, [0, -1, -1, -1], 1))
    assert session.drive([0.2, 0.0, 0.0, 0.0]).outcome.name == "you and refined"


def test_a_session_that_a_maneuver_drives_reaches_what_the_rival_reaches():
    session = DriveSession(SHORT)
    session.hand_over("universal")
    while not session.ended:
        shown = session.drive()
    universal, slow = outcomes_of_rivals(SHORT)
    assert shown.outcome.time_to_s == universal.time_to_s
    assert shown.outcome.worst_sd == pytest.approx(universal.worst_sd, rel=1e-9)
    assert shown.outcome.discomfort_s == pytest.approx(universal.discomfort_s, abs=1e-9)
    assert slow.name == "slow_opening" and slow.worst_sd > universal.worst_sd


def test_an_agent_that_decides_five_times_a_second_drives_as_in_its_own_environment():
    agents = {"five_hz": Player("refined", control="targets")}
    session = DriveSession(SHORT, agents)
    session.hand_over("five_hz")
    while not session.ended:
        shown = session.drive()
    own = outcomes_of_rivals(SHORT, agents)[0]
    assert shown.driver == own.name == "five_hz"
    assert shown.outcome.worst_sd == pytest.approx(own.worst_sd, rel=0.05)
    assert shown.outcome.time_to_s == pytest.approx(own.time_to_s, abs=0.2)


def test_an_agent_is_taken_over_given_back_and_refused_where_it_cannot_drive():
    agents = {"own": Player("refined", control="targets")}
    session = DriveSession(SHORT, agents)
    session.hand_over("own")
    for _ in range(8):
        sent = session.drive().targets
    session.hand_over(BY_HAND)
    np.testing.assert_allclose(session.drive().targets, np.clip(sent, [0, -1, -1, -1], 1))
    session.hand_over("own")
    assert session.drive().outcome.name == "you and own"
    with pytest.raises(InputError):
        DriveSession(Setup.of(seed=500, control="force"), agents).hand_over("own")
    assert [one.name for one in outcomes_of_rivals(Setup.of(seed=500, episode_s=1.0, control="force"), agents)] == [
        "universal",
        "slow_opening",
    ]


def test_the_file_of_a_drive_plays_it_again(driven, tmp_path):
    session, shown, _ = driven
    maneuver, recording = session.save(tmp_path)
    assert (maneuver.name, recording.name) == ("my_drive_1.yaml", "my_drive_1.csv")
    again = DriveSession(SHORT)
    again.hand_over(str(maneuver))
    while not again.ended:
        played = again.drive()
    np.testing.assert_allclose(played.scene.belief_mean, shown.scene.belief_mean, atol=1e-4)
    assert session.save(tmp_path)[0].name == "my_drive_2.yaml"
    (entry,) = load_entries([str(maneuver)])
    assert entry.label == "my_drive_1"


def test_the_recording_of_a_drive_shows_the_same_jaw_and_belief(driven, tmp_path):
    session, shown, _ = driven
    playback = Playback(load_record(session.save(tmp_path)[1]), "a drive")
    last = playback.shown(len(playback) - 1)
    assert last.ended and len(playback) == 61
    np.testing.assert_allclose(last.scene.belief_mean, shown.scene.belief_mean, atol=0.02)
    np.testing.assert_allclose(last.scene.mouthpiece_m, shown.scene.mouthpiece_m, atol=2e-3)
    np.testing.assert_allclose(last.scene.muscle_tension_N, shown.scene.muscle_tension_N, rtol=0.2)


def test_the_same_patient_begins_again(driven):
    session = DriveSession(SHORT)
    first = session.drive([0.4, 0.0, 0.0, 0.0])
    begun = session.begin()
    assert begun.scene.time_s == 0.0 and begun.outcome.duration_s == 0.0
    np.testing.assert_array_equal(session.drive([0.4, 0.0, 0.0, 0.0]).scene.belief_mean, first.scene.belief_mean)


@pytest.mark.parametrize(("knowledge", "force_sensor"), [(IMAGED, "cell"), (Knowledge(**BODY), "straps")])
def test_the_recording_of_a_drive_says_what_was_known(tmp_path, knowledge, force_sensor):
    session = DriveSession(Setup.of(seed=500, episode_s=3.0, knowledge=knowledge, force_sensor=force_sensor))
    session.drive([0.4, 0.0, 0.0, 0.0])
    paths = session.save(tmp_path)
    assert [path.suffix for path in paths] == [".yaml", ".csv"]
    record = load_record(paths[1])
    assert (record.knowledge, record.force_sensor) == (knowledge, force_sensor)


@pytest.mark.parametrize("targets", [[0.5, 0.0], "up", [-0.1, 0, 0, 0], [0, 0, 0, float("nan")]])
def test_targets_out_of_range_are_refused(driven, targets):
    with pytest.raises(InputError):
        driven[0].drive(targets)


@pytest.mark.parametrize("settings", [{"seed": -1}, {"knowledge": "vague"}, {"episode_s": 0.2}, {"env": "bird"}])
def test_a_setup_says_what_is_wrong(settings):
    with pytest.raises(InputError):
        Setup.of(**settings)


def test_nothing_driven_is_nothing_to_save(tmp_path):
    with pytest.raises(InputError):
        DriveSession(SHORT).save(tmp_path)


def test_an_outcome_within_comfort_is_one_that_is_ranked():
    good = DriveOutcome("you", (2.0, np.inf), 0.06, 0.05, 30.0, False)
    assert good.within_comfort
    assert not DriveOutcome("you", (2.0, 3.0), 0.06, 0.2, 30.0, False).within_comfort
    assert not DriveOutcome("you", (2.0, 3.0), 0.06, 0.0, 30.0, True).within_comfort


def test_verdicts_are_those_of_the_last_settled_belief():
    session = DriveSession(Setup.of(seed=500, episode_s=4.0, cohort="one_sided"))
    session.hand_over("refined")
    counts, steps = [], []
    while not session.ended:
        counts.append(int(session.drive().stands.sum()))
        steps.append(session.outcome().time_to_s[1])
    assert counts[0] == 0 and counts[-1] == 6 and min(counts[counts.index(6) :]) >= 5
    assert np.isinf(steps[0]) and np.isfinite(steps[-1])
