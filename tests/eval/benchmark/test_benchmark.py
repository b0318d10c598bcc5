"""The command: what it writes, what it keeps, and what it refuses."""

import shutil
from dataclasses import replace

import pandas as pd
import pytest

from eval.benchmark.run import cells_of, fitting_agents, left_out
from eval.benchmark.tasks import TASKS, tasks_named
from eval.commands.app import main
from eval.commands.benchmark import BASELINES, PAGE, PATIENTS
from eval.kept.cells import play_cells
from eval.kept.entries import Entry
from eval.kept.parts import Run
from tests.eval.benchmark.conftest import CIRCLES, play


def test_scores_are_the_times_of_the_patients(played):
    rows = pd.read_parquet(played / PATIENTS)
    assert list(rows["seed"]) == [50_000, 50_001] * 2
    assert list(dict.fromkeys(rows["agent"])) == ["slow_opening", "opening_with_circles"]
    assert (rows["score_s"] == rows["within_0.05_s"]).all() and rows["score_s"].between(0.0, 30.0).all()
    page = (played / PAGE).read_text()
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
    assert not (tmp_path / PAGE).exists()
    plays.fail_at = None
    assert play(tmp_path, "slow_opening", "chirp") == 0 and plays.names == ["slow_opening", "chirp"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["slow_opening", "--tasks", "jaw"], "tasks is 'jaw'; allowed: hinge-exact, jaw-exact"),
        (["slow_opening", "--tasks", ","], "tasks is none; allowed"),
        (["nobody"], "agent is 'nobody'; allowed"),
        (["ppo_trismus", "--tasks", "hinge-exact"], "was trained in jawenv/Jaw-v3, not in that of these tasks"),
        (["clairvoyant", "--tasks", "bilateral-exact"], "clairvoyant plans in another environment than that of these"),
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


def test_agents_of_one_name_are_told_apart(tmp_path):
    other = shutil.copy(CIRCLES, tmp_path / "other.yaml")
    cells = cells_of([CIRCLES, other], tasks_named(["hinge-exact", "jaw-exact"]))
    names = [f"opening_with_circles ({spec})" for spec in (CIRCLES, other)]
    assert [cell.levels["agent"] for cell in cells][::2] == names


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
