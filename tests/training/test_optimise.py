"""The search of maneuvers: its numbers, its judge, its constraint, and what a stopped search leaves."""

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import jawenv
from jawenv.device.channels import CHANNELS
from jawenv.errors import InputError
from jawenv.playing.maneuvers import Maneuver, Player
from jawenv.playing.maneuvers.maneuver import FOLDER
from training.cli import main
from training.search.optimise import CANDIDATE, INFEASIBLE, Design, Judge, Judged, nominal_patient, search
from training.search.waveform import N_NUMBERS, PEAKS, START, START_FADE_S, Sines, numbers_of, waves_of

SHORT = {"horizon_s": 2.0, "patients": 2, "population": 4, "generations": 3}


@given(arrays(float, N_NUMBERS, elements=st.floats(-5.0, 5.0)))
def test_any_numbers_make_a_maneuver_within_its_channels(numbers):
    """The file's own checks refuse one that leaves them."""
    maneuver = Sines().maneuver(numbers, CANDIDATE)
    for name in CHANNELS:
        low, high = maneuver.channels.signal(name).bounds()
        assert high <= PEAKS[name][1] + 2e-6 and low >= (0.0 if name == "opening" else -PEAKS[name][1]) - 2e-6


def test_numbers_and_waves_are_the_same_thing():
    waves, fade = waves_of(numbers_of(START, START_FADE_S))
    assert fade == pytest.approx(START_FADE_S)
    for name, wave in START.items():
        for value, expected in zip(waves[name], wave, strict=True):
            np.testing.assert_allclose(value, np.mod(expected, 360.0) if np.any(np.less(expected, 0)) else expected)


@given(arrays(float, N_NUMBERS, elements=st.floats(0.05, 0.95)))
def test_numbers_come_back(numbers):
    waves, fade = waves_of(numbers)
    np.testing.assert_allclose(numbers_of(waves, fade), numbers, atol=1e-9)


@pytest.mark.parametrize("control", ["targets", "trajectory"])
def test_a_candidate_is_judged_as_it_is_played_alone(control):
    """Largest sd and discomfort of the second of two candidates, by the public way of playing a maneuver."""
    design = Design(**SHORT, control=control)
    candidates = [Sines().maneuver(numbers_of(START, fade), CANDIDATE) for fade in (1.0, 2.0)]
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
    candidate = Sines().maneuver(numbers_of(START, 1.0), CANDIDATE)
    exact, imaged = (Judge(Design(**SHORT, env=env))([candidate])[0] for env in ("Jaw", "JawImaged"))
    assert imaged.worst_sd > 1.1 * exact.worst_sd
    with pytest.raises(InputError):
        Design(**SHORT, env="knee")


def test_what_breaks_the_constraint_ranks_behind_all_that_keeps_it():
    judge = Judge(Design(**SHORT))
    zero, known = np.zeros(2), np.array([-3.0, -3.1])
    kept = judge._judge(np.array([5.0, 5.0]), zero, zero, zero, np.ones(2))
    uneasy = judge._judge(known, np.full(2, 0.01), zero, zero, np.ones(2))
    violating = judge._judge(known, zero, np.ones(2), zero, np.ones(2))
    assert kept.feasible and not uneasy.feasible and not violating.feasible
    assert kept.loss < uneasy.loss < violating.loss


@pytest.mark.parametrize(("over", "expected"), [("mean", -2.0), ("tail", -1.0)])
def test_the_tail_looks_at_those_who_are_known_least(over, expected):
    zero = np.zeros(3)
    judged = Judge(Design(**SHORT, over=over))._judge(np.array([-3.0, -1.0, -2.0]), zero, zero, zero, np.ones(3))
    assert judged.loss == pytest.approx(expected)


@pytest.mark.parametrize("criterion", ["worst", "D", "A"])
def test_criteria_of_a_covariance(criterion):
    covariance = np.diag([0.04, 0.01, 0.09])[None]
    expected = {"worst": np.log(0.3), "A": 0.5 * np.log(0.14 / 3.0), "D": np.log(0.2 * 0.1 * 0.3) / 3.0}[criterion]
    assert Judge(Design(**SHORT, criterion=criterion))._criterion(covariance)[0] == pytest.approx(expected)


def test_the_nominal_patient_has_the_cohorts_medians():
    patient = nominal_patient("one_sided")
    np.testing.assert_allclose(patient.log_parameters(), jawenv.cohort("one_sided").prior.mean, atol=1e-12)


def bowl(target):
    """A judge with a minimum at the maneuver whose peak of side is ``target``."""

    def judge(maneuvers):
        peaks = [m.channels.signal("side").value(np.arange(0.0, 20.0, 0.01)).max() for m in maneuvers]
        return [Judged((peak - target) ** 2, 0.0, 0.0, 0.0, 0.0, 0.1) for peak in peaks]

    return judge


def test_the_search_finds_a_minimum_and_goes_on_where_it_was_stopped(tmp_path):
    design = Design(population=8, generations=30, sigma=0.2)
    whole = search(design, tmp_path / "whole.txt", lambda *_: None, bowl(0.4))
    assert whole.judged.loss < 1e-3

    class StoppedError(Exception):
        pass

    def stop(done, _):
        if done == 12:
            raise StoppedError

    with pytest.raises(StoppedError):
        search(design, tmp_path / "log.txt", stop, bowl(0.4))
    with (tmp_path / "log.txt").open("a") as file:
        file.write("0.1 0.2")  # half a line
    asked = []

    def counting(maneuvers):
        asked.append(len(maneuvers))
        return bowl(0.4)(maneuvers)

    resumed = search(design, tmp_path / "log.txt", lambda *_: None, counting)
    assert len(asked) == 30 - 12 + 1
    assert len((tmp_path / "log.txt").read_text().splitlines()) == 1 + 30
    np.testing.assert_array_equal(resumed.numbers, whole.numbers)


def test_a_log_is_of_what_was_refined_not_of_its_name(tmp_path):
    """A file that was changed meanwhile has other losses."""
    base, log = tmp_path / "base.yaml", tmp_path / "log.txt"
    base.write_text((FOLDER / "slow_opening.yaml").read_text())
    design = Design(population=4, generations=1, refine=str(base))
    search(design, log, lambda *_: None, bowl(0.4))
    search(design, log, lambda *_: None, bowl(0.4))
    base.write_text((FOLDER / "hold_still.yaml").read_text())
    with pytest.raises(InputError):
        search(design, log, lambda *_: None, bowl(0.4))


def test_the_command_writes_a_file_that_plays(tmp_path, capsys):
    output = tmp_path / "found_it.yaml"
    options = ["--horizon-s", "2", "--patients", "2", "--population", "4", "--generations", "2"]
    assert main(["optimise", "--output", str(output), *options]) == 0
    maneuver = Maneuver.load(output)
    assert maneuver.name == "found_it" and "horizon-s 2" in output.read_text()
    assert "largest sd" in capsys.readouterr().err
    assert yaml.safe_load(output.read_text())["fade_in_s"] > 0.0
    assert main(["optimise", "--output", str(tmp_path / "no" / "x.yaml")]) == 2
    assert main(["optimise", "--output", str(tmp_path / "My File.yaml")]) == 2
    assert INFEASIBLE > 100.0
    assert main(["optimise", "--output", str(tmp_path / "finer.yaml"), "--refine", str(output), *options]) == 0
    finer = (tmp_path / "finer.yaml").read_text()
    assert f"--refine {output}" in finer and Maneuver.load(tmp_path / "finer.yaml").description.startswith("'found_it'")
