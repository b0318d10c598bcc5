"""The command: what it writes, what it keeps, and what a check finds."""

import json
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from eval.benchmark import submission
from eval.benchmark.check import check, drawn
from eval.benchmark.run import cells_of, parts_of_cell
from eval.benchmark.submission import FILE, PATIENTS, refuse_copies
from eval.benchmark.tasks import TASKS, tasks_named
from eval.cli import main
from eval.kept.parts import Run
from eval.kept.tables import read_table, write_table
from jawenv.errors import InputError
from tests.eval.runs import save_run

ROOT = Path(__file__).parents[3]
CIRCLES = str(ROOT / "examples" / "opening_with_circles.yaml")
ONE = Run(workers=1)


def play(output, *arguments):
    small = ("--tasks", "hinge-exact", "--patients", "2", "--workers", "1")
    return main(["benchmark", *(arguments or ("slow_opening", CIRCLES)), *small, "--output", str(output)])


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    folder = tmp_path_factory.mktemp("benchmark") / "submission"
    assert play(folder) == 0
    return folder


@pytest.fixture
def copied(played, tmp_path):
    return Path(shutil.copytree(played, tmp_path / "submission"))


def changed(folder, change):
    """Write ``submission.json`` with a change."""
    data = json.loads((folder / FILE).read_text())
    change(data)
    (folder / FILE).write_text(json.dumps(data))


def changed_rows(folder, change):
    rows, about = read_table(folder / PATIENTS)
    change(rows)
    write_table(rows, folder / PATIENTS, about)


def test_a_submission_has_scores_patients_and_the_agents_files(played):
    given = submission.read(played)
    assert given.benchmark == "jawenv-1"
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


def test_a_check_passes_where_nothing_was_changed(played, capsys):
    assert main(["benchmark", "--check", str(played), "--workers", "1"]) == 0
    assert "reproduces: 4 episodes played again, 4 with the same score to the digit" in capsys.readouterr().out


def test_a_changed_score_is_found(copied, plays, capsys):
    changed(copied, lambda data: data["scores"][1].update(score_s=0.1))
    assert main(["benchmark", "--check", str(copied), "--workers", "1"]) == 2
    error = capsys.readouterr().err
    assert "does not reproduce: hinge-exact, opening_with_circles: the score is 0.1 s of 2 patients" in error
    assert error.count("\n") == 1 and not plays.names


def test_a_score_that_was_changed_with_its_patients_is_found_by_playing(copied, plays):
    changed_rows(copied, lambda rows: rows.update({"score_s": 0.5 * rows["score_s"]}))
    rows = read_table(copied / PATIENTS)[0]
    scores = [
        submission.scored("hinge-exact", agent, cell).model_dump() for agent, cell in rows.groupby("agent", sort=False)
    ]
    changed(copied, lambda data: data.update(scores=scores))
    found = check(copied, run=ONE)
    assert (found.played, found.equal, len(found.faults)) == (4, 0, 2) and len(plays.names) == 2
    assert "2 patients differ, as seed 50000" in found.faults[0]


def test_a_difference_of_one_control_step_is_that_of_another_processor(copied):
    changed_rows(copied, lambda rows: rows.update({"score_s": rows["score_s"] + 0.2}))
    rows = read_table(copied / PATIENTS)[0]
    scores = [
        submission.scored("hinge-exact", agent, cell).model_dump() for agent, cell in rows.groupby("agent", sort=False)
    ]
    changed(copied, lambda data: data.update(scores=scores))
    found = check(copied, run=ONE)
    assert (found.played, found.equal, found.faults) == (4, 0, ())


def test_a_changed_file_of_an_agent_is_found(copied):
    given = submission.read(copied)
    path = copied / given.agents[1].copy_at
    path.write_text(path.read_text() + "\n# changed\n")
    assert check(copied, run=ONE).faults == ("opening_with_circles: its files have changed since it was played",)


def test_missing_and_other_patients_are_found(copied):
    changed_rows(copied, lambda rows: rows.update({"seed": rows["seed"] + 1}))
    assert "the patients are not those of seeds 50000 to 50001" in check(copied, run=ONE).faults[0]
    changed(copied, lambda data: data["scores"].pop())
    assert check(copied, run=ONE).faults[0] == "hinge-exact, opening_with_circles: patients without a score"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda data: data.update(tasks_digest="0" * 16), "digest '0000000000000000'; this jawenv plays jawenv-1"),
        (lambda data: data["agents"][1].update(copy_at="agents/../../x.yaml"), "allowed is a path within agents/"),
        (lambda data: data["agents"][1].update(copy_at=None), "is none of jawenv's, and the folder has no copy of it"),
        (lambda data: data["agents"][0].update(spec="a.module:Name"), "runs code; allowed if you trust it: --trust"),
        (lambda data: data["scores"].append(data["scores"][0]), "is there twice; allowed: once"),
        (lambda data: data["scores"][0].update(score_s="soon"), "score_s"),
    ],
)
def test_a_submission_that_cannot_be_checked_is_refused_in_one_line(copied, capsys, change, message):
    changed(copied, change)
    assert main(["benchmark", "--check", str(copied), "--workers", "1"]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["slow_opening", "--tasks", "jaw"], "tasks: 'jaw' given, allowed are hinge-exact, jaw-exact"),
        (["slow_opening", "--tasks", ","], "tasks: none given"),
        ([], "nothing to play: name a maneuver"),
        (["nobody"], "agent 'nobody': unknown"),
        (["ppo_trismus", "--tasks", "hinge-exact"], "was trained in jawenv/Jaw-v2, where none of these tasks"),
        (["slow_opening", "--check", "x"], "--check: plays what the submission names"),
        (["--check", "nowhere"], "nowhere/submission.json"),
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
    assert [(cell.task.id, cell.agent) for cell in cells] == [
        ("jaw-exact", "ppo_force"),
        ("hinge-exact", "slow_opening"),
        ("jaw-exact", "slow_opening"),
    ]
    assert "played with control force" in cells[0].note and not cells[1].note
    assert cells[0].load().env_kwargs["control"] == "force"


def test_a_runs_files_are_copied_so_that_they_load(tmp_path):
    run = save_run(tmp_path / "my_run", CIRCLES)
    jaw = tasks_named(["jaw-exact"])
    cells = cells_of([str(run), str(run / "checkpoints" / "step_1.zip")], jaw)
    kept = submission.keep_agents(cells, tmp_path / "out")
    assert [each.copy_at for each in kept] == ["agents/0/my_run", "agents/1/my_run/checkpoints/step_1.zip"]
    loaded = cells_of([str(tmp_path / "out" / each.copy_at) for each in kept], jaw)
    assert [cell.agent for cell in loaded] == [cell.agent for cell in cells]
    assert submission.fingerprint_of(str(tmp_path / "out" / kept[0].copy_at)) == kept[0].fingerprint


def test_agents_of_one_name_are_told_apart(tmp_path):
    other = shutil.copy(CIRCLES, tmp_path / "other.yaml")
    cells = cells_of([CIRCLES, other], tasks_named(["hinge-exact", "jaw-exact"]))
    assert len({cell.agent for cell in cells}) == 2 and all(f"({cell.spec})" in cell.agent for cell in cells)


def test_an_agent_within_the_output_is_refused(tmp_path):
    with pytest.raises(InputError, match="name another output"):
        refuse_copies([str(tmp_path / "agents" / "0" / "mine.yaml")], tmp_path)


def test_patients_are_played_in_tens_so_that_a_part_can_be_checked(tmp_path):
    (cell,) = cells_of(["random"], tasks_named(["hinge-exact"]))
    parts = parts_of_cell(cell, tmp_path, 25)
    assert [(part.first, part.number) for part in parts] == [(50_000, 10), (50_010, 10), (50_020, 5)]
    assert len(parts_of_cell(cell, tmp_path)) == 10


def test_a_check_of_some_patients_draws_whole_parts(tmp_path):
    (cell,) = cells_of(["random"], tasks_named(["hinge-exact"]))
    parts = parts_of_cell(cell, tmp_path)
    draws = [drawn(parts, 15, np.random.default_rng(seed)) for seed in (0, 0, 1)]
    assert draws[0] == draws[1] != draws[2] and all(len(draw) == 2 for draw in draws)
    assert drawn(parts, None, np.random.default_rng(0)) == parts == drawn(parts, 500, np.random.default_rng(0))
