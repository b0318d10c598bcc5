"""The command: what it writes, what it keeps, and what it refuses."""

import re
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
import pytest
import scipy.stats

from eval.benchmark import run
from eval.benchmark.run import DRAWN, PUBLIC, drawn_seeds, fitting_agents, left_out
from eval.benchmark.tables import check_table
from eval.benchmark.tasks import TASKS, tasks_named
from eval.commands.app import main
from eval.commands.benchmark import BASELINES, PAGE, PATIENTS
from eval.figures import words
from eval.figures.statistics import Interval, difference
from eval.kept.cells import play_cells
from eval.kept.entries import Entry
from eval.kept.parts import Run
from tests.eval.benchmark.conftest import CIRCLES, play

cells_of = partial(run.cells_of, key="a key")


def test_scores_are_the_times_of_the_patients(played):
    every = pd.read_parquet(played / PATIENTS)
    rows = every[every["patients"] == PUBLIC]
    assert list(rows["seed"]) == [50_000, 50_001] * 2
    assert list(dict.fromkeys(rows["agent"])) == ["slow_opening", "opening_with_circles"]
    assert (rows["score_s"] == rows["within_0.05_s"]).all() and rows["score_s"].between(0.0, 30.0).all()
    page = (played / PAGE).read_text()
    assert "Not all patients were played: 2 of 100 in hinge-exact." in page and "| slow opening | " in page


def test_other_patients_are_drawn_by_a_key_that_the_page_says(played, tmp_path):
    drawn = {}
    for folder in (played, tmp_path):
        key = re.search("Drawn by `--key (.+)`", (played / PAGE).read_text())[1]
        if folder is tmp_path:
            assert play(folder, "slow_opening", CIRCLES, "--key", key) == 0
        rows = pd.read_parquet(folder / PATIENTS)
        drawn[folder] = rows[rows["patients"] == DRAWN].reset_index(drop=True)
    pd.testing.assert_frame_equal(drawn[played], drawn[tmp_path])
    assert (drawn[played]["seed"] > 2**32).any() and len(key) == 32
    assert not set(drawn_seeds("hinge-exact", 9, key)) & set(drawn_seeds("hinge-exact", 9, key + "0"))


def test_drawn_patients_stand_beside_the_public_ones_with_an_interval_of_two_samples():
    public, drawn = np.array([1.0, 2.0, 3.0, 4.0]), np.array([3.0, 4.0, 5.0, 8.0])
    times = {PUBLIC: public, DRAWN: drawn}
    rows = pd.concat(
        [pd.DataFrame({"task": "jaw-exact", "agent": "a", "patients": on, "score_s": s}) for on, s in times.items()]
    )
    ends = scipy.stats.ttest_ind(drawn, public, equal_var=False).confidence_interval()
    (row,) = check_table(rows).rows
    assert row[-1] == words.with_interval(Interval(2.5, ends.low, ends.high), 2)
    assert difference(public, public[:1]).exists is False and difference(np.ones(3), np.ones(2)).low == 0.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["slow_opening", "--tasks", "jaw"], "tasks is 'jaw'; allowed: hinge-exact, jaw-exact"),
        (["slow_opening", "--tasks", ","], "tasks is none; allowed"),
        (["nobody"], "agent is 'nobody'; allowed"),
        (["ppo_trismus", "--tasks", "hinge-exact"], "was trained in jawenv/Jaw-v3, not in that of these tasks"),
        (["clairvoyant", "--tasks", "hinge-exact"], "clairvoyant plans in another environment than that of these"),
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
    cells = cells_of(["ppo_trismus", "slow_opening"], tasks_named(["hinge-exact", "jaw-exact"]))[::2]
    assert [tuple(cell.levels.values())[:2] for cell in cells] == [
        ("jaw-exact", "ppo_trismus"),
        ("hinge-exact", "slow_opening"),
        ("jaw-exact", "slow_opening"),
    ]
    assert all(cell.load().env_kwargs["control"] == "targets" for cell in cells)


def test_every_task_has_an_agent_at_rest():
    cells = cells_of([*BASELINES], tasks_named())
    agents = {task: {cell.levels["agent"] for cell in cells if cell.levels["task"] == task} for task in TASKS}
    assert all("hold_still" in played for played in agents.values()) and len(set(BASELINES)) == len(BASELINES)


def test_a_task_alone_is_played_by_the_baselines_that_fit_it():
    tasks = tasks_named(["jaw-imaged-memory"])
    fitting = fitting_agents(BASELINES, tasks)
    assert "apg_asked" not in fitting and "refined" in fitting
    assert len(cells_of(fitting, tasks)) == 2 * len(fitting)


def test_who_is_left_out_of_a_task_is_one_line():
    tasks = tasks_named(["hinge-exact", "jaw-exact"])
    cells = cells_of(["slow_opening", "clairvoyant"], tasks)
    assert list(left_out(cells, tasks)) == ["clairvoyant is for other environments than: hinge-exact"]


def test_patients_are_played_in_parts_of_fifty_so_that_a_part_can_be_checked(tmp_path):
    cell, _ = cells_of(["random"], tasks_named(["hinge-exact"]))
    parts = replace(cell, seeds=cell.seeds[:70]).parts(tmp_path)
    assert [(part.first, part.number) for part in parts] == [(50_000, 50), (50_050, 20)]
    assert len(cell.parts(tmp_path)) == 2


def test_an_agent_draws_by_the_place_of_its_part_and_not_by_the_worlds_seed(tmp_path, monkeypatch):
    told, real = [], Entry.play

    def heard(entry, *more, **changes):
        told.append(entry.agent_seed)
        return real(entry, *more, **changes)

    monkeypatch.setattr(Entry, "play", heard)
    cell, _ = cells_of(["random"], tasks_named(["hinge-exact"]))
    for seeds, folder in ((cell.seeds[:3], "a"), (cell.seeds[7:10], "b")):
        play_cells([replace(cell, seeds=seeds, size=2)], tmp_path / folder, Run(workers=1))
    assert told == [0, 2, 0, 2]
