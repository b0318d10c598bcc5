"""The command: what it writes, what it keeps, and what it refuses."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from agents.registry import world_of
from agents.replay import Replay
from eval.benchmark import submission
from eval.benchmark.labels import is_label_of, label_of, numbered
from eval.benchmark.run import cells_of, fitting_agents, left_out
from eval.benchmark.submission import FILE, PATIENTS, refuse_copies
from eval.benchmark.tasks import TASKS, tasks_named
from eval.commands.app import main
from eval.commands.benchmark import BASELINES
from eval.kept.cells import play_cells
from eval.kept.entries import Entry
from eval.kept.parts import Run
from jawenv.base.errors import InputError
from jawenv.playing.maneuvers import Maneuver
from tests.eval.benchmark.conftest import CIRCLES, play
from tests.eval.runs import save_run


def test_a_submission_has_scores_patients_and_the_agents_files(played):
    given = submission.read(played)
    assert given.benchmark == "jawenv-2"
    assert [(score.task, score.agent, score.patients) for score in given.scores] == [
        ("hinge-exact", "slow_opening", 2),
        ("hinge-exact", "opening_with_circles", 2),
    ]
    assert {"command", "versions", "git", "machine", "finished"} <= set(given.made_with)
    named, file = given.agents
    assert (named.copy_at, named.fingerprint) == (None, None)
    assert (played / file.copy_at).read_bytes() == Path(CIRCLES).read_bytes() and len(file.fingerprint) == 64
    rows = pd.read_parquet(played / PATIENTS)
    assert list(rows["seed"]) == [50_000, 50_001] * 2
    for score in given.scores:
        times = rows.loc[rows["agent"] == score.agent, "score_s"]
        assert score.score_s == times.mean() and 0.0 < score.score_s < 30.0
        assert np.array_equal(times, rows.loc[rows["agent"] == score.agent, "within_0.05_s"])
    page = (played / "benchmark.md").read_text()
    assert "Of each task the first 2 of 100 patients were played." in page and "| slow opening | " in page


def test_only_what_is_missing_is_played(tmp_path, plays, capsys):
    assert play(tmp_path, "slow_opening", "chirp") == 0 and plays.names == ["slow_opening", "chirp"]
    assert play(tmp_path, "chirp", "prbs", "slow_opening") == 0 and plays.names[2:] == ["prbs"]
    assert "4 of 6 episodes kept from an earlier run" in capsys.readouterr().out
    assert play(tmp_path, "chirp", "--fresh") == 0 and plays.names[3:] == ["chirp"]


def test_an_interrupt_keeps_what_is_finished(tmp_path, plays, capsys):
    plays.fail_at = 1
    assert play(tmp_path, "slow_opening", "chirp") == 130
    assert "the same command goes on from there" in capsys.readouterr().err
    assert not (tmp_path / FILE).exists()
    plays.fail_at = None
    assert play(tmp_path, "slow_opening", "chirp") == 0 and plays.names == ["slow_opening", "chirp"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["slow_opening", "--tasks", "jaw"], "tasks is 'jaw'; allowed: hinge-exact, jaw-exact"),
        (["slow_opening", "--tasks", ","], "tasks is none; allowed"),
        ([], "nothing to play: name a maneuver"),
        (["nobody"], "agent is 'nobody'; allowed"),
        (["ppo_trismus", "--tasks", "hinge-exact"], "was trained in jawenv/Jaw-v3, not in that of these tasks"),
        (["slow_opening", "--check", "x"], "--check: plays what the submission names"),
        (["clairvoyant", "--tasks", "bilateral-exact"], "clairvoyant plans in another environment than that of these"),
        (["slow_opening", "--baselines"], "--baselines: plays what comes with jawenv, and not 'slow_opening'"),
        (["--check", "nowhere"], "nowhere/submission.json"),
        (["--check", "nowhere", "--fresh-seeds", "2", "--key", "x"], "--key is 'x'; allowed: hexadecimal digits"),
        (["slow_opening", "--fresh-seeds", "2"], "--fresh-seeds and --key: belong to --check"),
    ],
)
def test_what_cannot_be_played_is_one_line(tmp_path, capsys, arguments, message):
    assert main(["benchmark", *arguments, "--output", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1 and not (tmp_path / "out").exists()


def test_the_list_names_every_task(capsys):
    assert main(["benchmark", "--list"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == list(TASKS)


def test_an_agent_plays_the_tasks_of_its_environment_in_its_own_control():
    cells = cells_of(["ppo_force", "slow_opening"], tasks_named(["hinge-exact", "jaw-exact"]))
    assert [tuple(cell.levels.values()) for cell in cells] == [
        ("jaw-exact", "ppo_force"),
        ("hinge-exact", "slow_opening"),
        ("jaw-exact", "slow_opening"),
    ]
    assert "played with control force" in cells[0].load().note and not cells[1].load().note
    assert cells[0].load().env_kwargs["control"] == "force"


def test_every_task_has_an_agent_at_rest():
    cells = cells_of([*BASELINES], tasks_named())
    agents = {task: {cell.levels["agent"] for cell in cells if cell.levels["task"] == task} for task in TASKS}
    assert all("hold_still" in played for played in agents.values()) and len(set(BASELINES)) == len(BASELINES)


def test_a_task_alone_is_played_by_the_baselines_that_fit_it():
    tasks = tasks_named(["jaw-imaged-memory"])
    fitting = fitting_agents(BASELINES, tasks)
    assert "apg_asked" not in fitting and "refined" in fitting
    assert len(cells_of(fitting, tasks)) == len(fitting)


def test_who_is_left_out_of_a_task_is_one_line():
    tasks = tasks_named(["hinge-exact", "jaw-exact"])
    cells = cells_of(["slow_opening", "clairvoyant"], tasks)
    assert list(left_out(cells, tasks)) == ["clairvoyant is for other environments than: hinge-exact"]


def test_a_runs_files_are_copied_so_that_they_load(tmp_path):
    run = save_run(tmp_path / "my_run", Maneuver.load(CIRCLES))
    jaw = tasks_named(["jaw-exact"])
    cells = cells_of([str(run)], jaw)
    specs = [str(run), str(run / "checkpoints" / "step_1.zip")]
    kept = submission.keep_agents(dict(zip(("run", "checkpoint"), specs, strict=True)), tmp_path / "out")
    assert [each.copy_at for each in kept] == ["agents/0/my_run", "agents/1/my_run/checkpoints/step_1.zip"]
    loaded = cells_of([str(tmp_path / "out" / kept[0].copy_at)], jaw)
    assert [cell.levels for cell in loaded] == [cell.levels for cell in cells]
    for each, spec in zip(kept, specs, strict=True):
        copied = str(tmp_path / "out" / each.copy_at)
        assert submission.fingerprint_of(copied) == each.fingerprint == submission.fingerprint_of(spec)
        assert world_of(copied) == world_of(run)


def test_agents_of_one_name_are_told_apart(tmp_path):
    other = shutil.copy(CIRCLES, tmp_path / "other.yaml")
    cells = cells_of([CIRCLES, other], tasks_named(["hinge-exact", "jaw-exact"]))
    assert [cell.levels["agent"] for cell in cells][::2] == ["opening_with_circles (1)", "opening_with_circles (2)"]
    assert all(is_label_of(str(cell.levels["agent"]), cell.load().label) for cell in cells)


@pytest.mark.parametrize(
    "name", ["<script>alert(1)</script>", "a | 1", "[x](javascript:a)", "x" * 100, "\u202egpj", ""]
)
def test_a_label_has_plain_signs_alone(name):
    label = label_of(name)
    assert label == label_of(label) and len(label) <= 60 and not set(label) & set("<>|[]:\u202e")
    assert is_label_of(label, name) and is_label_of(numbered(label, 2), name) and not is_label_of("refined", name)


def test_copies_of_agents_are_replaced_when_all_new_ones_are_written(tmp_path, monkeypatch):
    submission.keep_agents({"mine": CIRCLES}, tmp_path)
    old = tmp_path / "agents" / "0" / "examples" / "opening_with_circles.yaml"
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    other = Path(shutil.copy(CIRCLES, tmp_path.parent / "other.yaml"))

    def fails(path, *more):
        raise InputError(f"{path}: cannot be read")

    with monkeypatch.context() as patch, pytest.raises(InputError):
        patch.setattr(submission, "read_bytes", fails)
        submission.keep_agents({"other": str(other)}, tmp_path)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before and len(before) == 1
    (kept,) = submission.keep_agents({"other": str(other)}, tmp_path)
    assert (tmp_path / kept.copy_at).is_file() and kept.copy_at.endswith("other.yaml")
    assert [path.name for path in tmp_path.iterdir()] == ["agents"] and old not in tmp_path.rglob("*")


def test_a_link_in_place_of_copies_goes_and_its_target_stays(tmp_path):
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "mine.txt").write_text("mine")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "agents").symlink_to(tmp_path / "elsewhere")
    submission.keep_agents({"slow_opening": "slow_opening"}, tmp_path / "out")
    assert not (tmp_path / "out" / "agents").exists() and (tmp_path / "elsewhere" / "mine.txt").read_text() == "mine"


def test_recorded_actions_for_each_patient_are_no_agent(tmp_path, capsys, plays):
    path = tmp_path / "answers.npz"
    Replay("answers", np.zeros((2, 5, 4)), 5.0).save(path)
    assert play(tmp_path / "out", str(path)) == 2 and not plays.names
    assert "holds 2 sequences of actions; allowed in the benchmark: one for all patients" in capsys.readouterr().err
    Replay("answers", np.zeros((1, 5, 4)), 5.0).save(path)
    assert play(tmp_path / "out", str(path)) == 0
    copy = tmp_path / "out" / submission.read(tmp_path / "out").agents[0].copy_at
    Replay("answers", np.zeros((2, 5, 4)), 5.0).save(copy)
    capsys.readouterr()
    assert main(["benchmark", "--check", str(tmp_path / "out"), "--workers", "1"]) == 2
    assert "holds 2 sequences of actions" in capsys.readouterr().err


def test_an_agent_within_the_output_is_refused(tmp_path):
    with pytest.raises(InputError):
        refuse_copies([str(tmp_path / "agents" / "0" / "mine.yaml")], tmp_path)


def test_patients_are_played_in_parts_of_fifty_so_that_a_part_can_be_checked(tmp_path):
    (cell,) = cells_of(["random"], tasks_named(["hinge-exact"]))
    parts = replace(cell, seeds=cell.seeds[:70]).parts(tmp_path)
    assert [(part.first, part.number) for part in parts] == [(50_000, 50), (50_050, 20)]
    assert len(cell.parts(tmp_path)) == 2


def test_an_agent_draws_by_the_place_of_its_part_and_not_by_the_worlds_seed(tmp_path, monkeypatch):
    told, real = [], Entry.play

    def heard(entry, *more, **changes):
        told.append(entry.agent_seed)
        return real(entry, *more, **changes)

    monkeypatch.setattr(Entry, "play", heard)
    (cell,) = cells_of(["random"], tasks_named(["hinge-exact"]))
    for seeds, folder in ((cell.seeds[:3], "a"), (cell.seeds[7:10], "b")):
        play_cells([replace(cell, seeds=seeds, size=2)], tmp_path / folder, Run(workers=1))
    assert told == [0, 2, 0, 2]
