"""The search that refines a maneuver: its numbers, its judge, its constraint, and what a stopped search leaves."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import jawenv
from jawenv.base.errors import InputError
from jawenv.device.channels import FASTEST_TARGET
from jawenv.playing.maneuvers import Maneuver, Player
from jawenv.playing.maneuvers.maneuver import FOLDER
from training.cli import main
from training.search.optimise import (
    CANDIDATE,
    SIZE,
    STEP_S,
    Judge,
    Knots,
    _Judged,
    _length_s,
    nominal_patient,
    search,
)
from training.search.settings import Refinement

SHORT = {"refine": "slow_opening", "horizon_s": 2.0, "patients": 2, "population": 4, "generations": 3}
TIMES = STEP_S * np.arange(1, 11)


@pytest.mark.parametrize("name", ["refined", "opening_with_swings"])
def test_without_offsets_a_maneuver_is_itself(name):
    base = Maneuver.named(name)
    knots = Knots(base, 2.0)
    again = knots.maneuver(knots.start, CANDIDATE)
    np.testing.assert_allclose(again.targets(TIMES).value, base.targets(TIMES).value, atol=1e-5)


def test_what_lies_behind_the_horizon_stays():
    base = Maneuver.named("refined")
    assert _length_s(base) == 30.0 and _length_s(Maneuver.named("opening_with_swings")) == 0.0
    knots = Knots(base, 4.0)
    changed = knots.targets(knots.start + 0.3)
    late = STEP_S * np.arange(27, 151)  # a second later any difference is caught up
    np.testing.assert_allclose(changed[26:], base.targets(late).value, atol=1e-9)
    assert np.abs(changed[:20] - base.targets(STEP_S * np.arange(1, 21)).value).max() > 0.05


def test_a_number_moves_its_channel_at_its_knot():
    knots = Knots(Maneuver.named("hold_still"), 2.0)
    numbers = np.zeros((5, 4))
    numbers[1, 2] = 0.5
    moved = knots.targets(numbers.ravel()) - knots.targets(knots.start)
    expected = np.zeros((10, 4))
    expected[2:5, 2] = 0.5 * SIZE[2] * np.array([0.5, 1.0, 0.5])
    np.testing.assert_allclose(moved, expected, atol=1e-12)


@settings(max_examples=20)
@given(arrays(float, 20, elements=st.floats(-50.0, 50.0)))
def test_any_numbers_make_a_maneuver_that_the_device_can_follow(numbers):
    knots = Knots(Maneuver.named("refined"), 2.0)
    path = np.vstack([np.zeros(4), knots.targets(numbers)])
    assert (np.abs(np.diff(path, axis=0)) <= np.array(FASTEST_TARGET) * STEP_S + 1e-12).all()
    np.testing.assert_allclose(knots.maneuver(numbers, CANDIDATE).targets(TIMES).value, path[1:11], atol=1e-5)


@pytest.mark.parametrize("control", ["targets", "trajectory"])
def test_a_candidate_is_judged_as_it_is_played_alone(control):
    """Largest sd and discomfort of the second of two candidates, by the public way of playing a maneuver."""
    design = Refinement(**SHORT, control=control)
    candidates = [Maneuver.named(name) for name in ("slow_opening", "opening_with_swings")]
    second = Judge(design)(candidates)[1]
    played = jawenv.play(Player(candidates[1], control=control), patients=2, seed=5_000, env_kwargs=design.env_kwargs)
    assert second.worst_sd == pytest.approx(np.median(played.belief_sd[:, -1].max(axis=1)), rel=1e-6)
    steps = len(played.time) - 1
    at = {
        weight: np.log(played.belief_sd[:, k].max(axis=1)) for weight, k in ((0.6, steps), (0.2, round(0.65 * steps)))
    }
    early = np.log(played.belief_sd[:, round(0.35 * steps)].max(axis=1))
    assert second.criterion == pytest.approx(np.mean(0.6 * at[0.6] + 0.2 * at[0.2] + 0.2 * early), rel=1e-6)
    assert second.discomfort_s == pytest.approx(jawenv.score(played).discomfort_s.mean(), abs=1e-9)


def test_a_candidate_is_played_in_the_environment_that_is_asked_for():
    candidate = Maneuver.named("refined")
    exact, imaged = (Judge(Refinement(**SHORT, env=env))([candidate])[0] for env in ("Jaw", "JawImaged"))
    assert imaged.worst_sd > 1.01 * exact.worst_sd
    with pytest.raises(InputError):
        Refinement(**SHORT, env="knee")


def test_what_breaks_the_constraint_ranks_behind_all_that_keeps_it():
    judge = Judge(Refinement(**SHORT))
    zero, known = np.zeros(2), np.array([-3.0, -3.1])
    kept = judge._judge(np.array([5.0, 5.0]), zero, zero, zero, np.ones(2))
    uneasy = judge._judge(known, np.full(2, 0.01), zero, zero, np.ones(2))
    violating = judge._judge(known, zero, np.ones(2), zero, np.ones(2))
    assert kept.feasible and not uneasy.feasible and not violating.feasible
    assert kept.loss < uneasy.loss < violating.loss


@pytest.mark.parametrize(("over", "expected"), [("mean", -2.0), ("tail", -1.0)])
def test_the_tail_looks_at_those_who_are_known_least(over, expected):
    zero = np.zeros(3)
    judged = Judge(Refinement(**SHORT, over=over))._judge(np.array([-3.0, -1.0, -2.0]), zero, zero, zero, np.ones(3))
    assert judged.loss == pytest.approx(expected)


@pytest.mark.parametrize("criterion", ["worst", "D", "A"])
def test_criteria_of_a_covariance(criterion):
    covariance = np.diag([0.04, 0.01, 0.09])[None]
    expected = {"worst": np.log(0.3), "A": 0.5 * np.log(0.14 / 3.0), "D": np.log(0.2 * 0.1 * 0.3) / 3.0}[criterion]
    assert Judge(Refinement(**SHORT, criterion=criterion))._criterion(covariance)[0] == pytest.approx(expected)


def test_the_nominal_patient_has_the_cohorts_medians():
    patient = nominal_patient("one_sided")
    np.testing.assert_allclose(patient.log_parameters(), jawenv.cohort("one_sided").prior.mean, atol=1e-12)


def bowl(maneuvers):
    """A judge with a minimum at maneuvers whose peak of side is 0.3."""
    peaks = [m.channels.signal("side").value(np.arange(0.0, 4.0, 0.1)).max() for m in maneuvers]
    return [_Judged((peak - 0.3) ** 2, 0.0, 0.0, 0.0, 0.0, 0.1) for peak in peaks]


def test_the_search_finds_a_minimum_and_goes_on_where_it_was_stopped(tmp_path):
    design = Refinement(refine="hold_still", horizon_s=4.0, population=8, generations=30, sigma=0.2)
    whole = search(design, tmp_path / "whole.pkl", lambda *_: None, bowl)
    assert whole.judged.loss < 1e-3

    class StoppedError(Exception):
        pass

    def stop(done, _):
        if done == 12:
            raise StoppedError

    with pytest.raises(StoppedError):
        search(design, tmp_path / "log.pkl", stop, bowl)
    np.random.random(7)
    asked, told = [], []

    def counting(maneuvers):
        asked.append(len(maneuvers))
        return bowl(maneuvers)

    resumed = search(design, tmp_path / "log.pkl", lambda done, _: told.append(done), counting)
    assert asked == [8] * 18 + [1] and told == list(range(13, 31))
    np.testing.assert_array_equal(resumed.numbers, whole.numbers)


@pytest.mark.parametrize("content", [b"", b"no pickle", pickle.dumps((1, 2)), pickle.dumps(({}, b"", None))])
def test_a_damaged_log_and_one_of_another_search_are_refused(tmp_path, content):
    log = tmp_path / "log.pkl"
    log.write_bytes(content)
    with pytest.raises(InputError):
        search(Refinement(**SHORT), log, lambda *_: None, bowl)


def test_a_log_is_of_what_was_refined_not_of_its_name_and_of_no_more_generations(tmp_path):
    """A file that was changed meanwhile has other losses."""
    base, log = tmp_path / "base.yaml", tmp_path / "log.pkl"
    base.write_text((FOLDER / "slow_opening.yaml").read_text())
    design = Refinement(**SHORT | {"refine": str(base)})
    for _ in range(2):
        search(design, log, lambda *_: None, bowl)
    with pytest.raises(InputError):
        search(Refinement(**SHORT | {"refine": str(base), "generations": 2}), log, lambda *_: None, bowl)
    base.write_text((FOLDER / "hold_still.yaml").read_text())
    with pytest.raises(InputError):
        search(design, log, lambda *_: None, bowl)


OPTIONS = ["--refine", "opening_with_swings", "--horizon-s", "2", "--patients", "2", "--population", "4"]
COMMAND = ["optimise", *OPTIONS, "--generations", "3", "--output"]


def test_the_command_writes_a_file_that_plays(tmp_path, capsys):
    output = tmp_path / "finer.yaml"
    assert main([*COMMAND, str(output)]) == 0
    text, maneuver = output.read_text(), Maneuver.load(output)
    assert maneuver.name == "finer" and maneuver.description.startswith("'opening_with_swings'")
    assert "--refine opening_with_swings" in text and "--horizon-s 2" in text
    assert "largest sd" in capsys.readouterr().err
    for name in ("no/x.yaml", "My File.yaml"):
        assert main([*COMMAND, str(tmp_path / name)]) == 2
    assert main(["optimise", "--output", str(tmp_path / "x.yaml")]) == 2
    assert "--refine" in capsys.readouterr().err


def test_an_interrupted_command_goes_on_to_the_same_file(tmp_path, capsys, monkeypatch):
    files = [tmp_path / folder / "mine.yaml" for folder in ("whole", "halves")]
    for file in files:
        file.parent.mkdir()
    calls = iter(range(9))

    def interrupted(judge, candidates):
        if next(calls) == 2:
            raise KeyboardInterrupt
        return play(judge, candidates)

    play = Judge.__call__
    with monkeypatch.context() as patch:
        patch.setattr(Judge, "__call__", interrupted)
        assert main([*COMMAND, str(files[1])]) == 130
    assert "goes on" in capsys.readouterr().err and [file.name for file in files[1].parent.iterdir()] == [
        "mine.search.pkl"
    ]
    for file in files:
        assert main([*COMMAND, str(file)]) == 0
    assert files[0].read_bytes() == files[1].read_bytes()
