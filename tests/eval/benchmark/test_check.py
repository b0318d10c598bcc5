"""What a check finds: submissions that are forged, each whole in itself."""

import json
import time

import numpy as np
import pandas as pd
import pytest

from eval.benchmark import submission, tables
from eval.benchmark.check import check, drawn
from eval.benchmark.differences import LARGEST_SHARE, faults_of
from eval.benchmark.submission import FILE, PAGE, PATIENTS
from eval.commands.app import main
from eval.kept.parts import Run
from eval.kept.tables import read_table, write_table
from eval.rows.times import COLUMNS

ONE = Run(workers=1)


def changed(folder, change):
    """Write ``submission.json`` with a change."""
    data = json.loads((folder / FILE).read_text())
    change(data)
    (folder / FILE).write_text(json.dumps(data))


def forged(folder, change):
    """Change the patients' rows, and make of them what the command would have: scores and page."""
    rows, about = read_table(folder / PATIENTS)
    rows = change(rows) if change is not None else rows
    write_table(rows, folder / PATIENTS, about)
    scores = [
        submission.scored(task, agent, cell).model_dump()
        for (task, agent), cell in rows.groupby(["task", "agent"], sort=False)
    ]
    changed(folder, lambda data: data.update(scores=scores))
    (folder / PAGE).write_text(tables.markdown(rows, about))


def elsewhere(folder):
    """Say that the submission was made by another processor."""
    rows, about = read_table(folder / PATIENTS)
    about["machine"]["processor"] = "another one"
    write_table(rows, folder / PATIENTS, about)
    changed(folder, lambda data: data.update(made_with=about))
    forged(folder, None)


def one_better(rows):
    return rows.assign(score_s=rows["score_s"] - 0.2)


def test_a_check_passes_where_nothing_was_changed_and_says_what_it_cannot_know(played, capsys):
    assert main(["benchmark", "--check", str(played), "--workers", "1"]) == 0
    said = capsys.readouterr().out
    assert "reproduces: 4 episodes played again, 4 with the same score to the digit" in said
    assert "every column, to the bit" in said and "the first 2 of 100, which is no whole submission" in said
    assert said.count("not known: ") == 3


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (one_better, "score_s of 2 patients differs, as seed 50000"),
        (lambda rows: rows.assign(discomfort_s=0.0, worst_sd=0.001), "worst_sd of 2 patients differs"),
        (lambda rows: rows.assign(violated=True), "violated of 2 patients differs, as seed 50000: True given"),
    ],
)
def test_rows_that_were_changed_with_scores_and_page_are_found_by_playing(copied, change, message):
    forged(copied, change)
    found = check(copied, run=ONE)
    assert found.played == 4 and message in found.faults[0]


def test_another_processor_may_differ_by_a_control_step(copied):
    elsewhere(copied)
    forged(copied, one_better)
    found = check(copied, run=ONE)
    assert (found.played, found.equal, found.faults, found.exact) == (4, 0, (), False)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda rows: rows[rows["seed"] < 50_001], "scores of 1 to 1 patients; allowed: as many for each, 2 at least"),
        (lambda rows: rows.drop(index=rows.index[-1]), "scores of 1 to 2 patients"),
        (lambda rows: rows.assign(seed=rows["seed"] + 1), "the patients are not those of seeds 50000 to 50001"),
        (lambda rows: rows.assign(agent=rows["agent"].replace("slow_opening", "mine")), "has scores, but is no agent"),
    ],
)
def test_fewer_and_other_patients_are_found_before_anything_is_played(copied, plays, change, message):
    forged(copied, change)
    assert message in check(copied, run=ONE).faults[0] and not plays.names


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda rows: rows.assign(score_s=rows["score_s"].astype(str)), "score_s holds other values"),
        (lambda rows: rows.assign(seed=rows["seed"].astype(float)), "seed holds other values"),
        (lambda rows: rows.assign(score_s=np.nan), "score_s holds values outside of an episode"),
        (lambda rows: rows.assign(agent=[None, *rows["agent"][1:]]), "agent holds other values"),
        (lambda rows: rows.assign(score_s_given=0.0), "columns are ['task', 'agent', 'seed'"),
        (lambda rows: pd.concat([rows, rows.assign(task="bogus")]), "bogus, slow_opening: patients without a score"),
    ],
)
def test_a_table_of_other_columns_or_values_is_one_line(copied, capsys, change, message):
    rows, about = read_table(copied / PATIENTS)
    write_table(change(rows), copied / PATIENTS, about)
    assert message in refused(copied, capsys)


def refused(folder, capsys, *more):
    """The one line by which a check refuses a folder."""
    assert main(["benchmark", "--check", str(folder), "--workers", "1", *more]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and error[:-1].isprintable()
    return error


def renamed(data):
    for each in (*data["agents"], *data["scores"]):
        each["agent"] = each["agent"].replace("slow", "fast")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda data: data.update(tasks_digest="0" * 16), "digest '0000000000000000'; this jawenv plays jawenv-2"),
        (lambda data: data["agents"][1].update(copy_at="agents/../../x.yaml"), "allowed: a path within agents/"),
        (lambda data: data["agents"][1].update(copy_at="."), "allowed: a path within agents/"),
        (lambda data: data["agents"][1].update(copy_at="a\0"), "printable"),
        (lambda data: data["agents"][1].update(copy_at=None), "is none of jawenv's, and the folder has no copy of it"),
        (lambda data: data["agents"][0].update(spec="a.module:Name"), "runs code; allowed if you trust it: --trust"),
        (lambda data: data["agents"][0].update(agent="\x1b[2J\nerror: fake"), "printable"),
        (lambda data: data["scores"].append(data["scores"][0]), "is there twice; allowed: once"),
        (lambda data: data["scores"][0].update(score_s="soon"), "score_s"),
        (lambda data: data["scores"][1].update(score_s=0.1), "opening_with_circles: the score is 0.1 s of 2 patients"),
        (lambda data: data["scores"][0].update(task="bogus"), "slow_opening: patients without a score"),
        (lambda data: data["scores"][0].update(note="a network of mine"), "the note is 'a network of mine'"),
        (lambda data: data["scores"].pop(), "hinge-exact, opening_with_circles: patients without a score"),
        (lambda data: data.update(made_with={"anything": ["goes"]}), "made_with"),
        (lambda data: data["made_with"].update(command="another"), "was made with something else"),
        (renamed, "slow_opening: patients without a score"),
    ],
)
def test_a_submission_that_is_not_whole_in_itself_is_refused_in_one_line(copied, capsys, plays, change, message):
    changed(copied, change)
    assert message in refused(copied, capsys) and not plays.names


def test_another_page_another_label_and_another_file_are_found(copied):
    forged(copied, None)
    (copied / PAGE).write_text("# slow opening: 0.1 s\n")
    assert check(copied, run=ONE).faults == ("benchmark.md: is not the page of these patients",)
    changed(copied, renamed)
    rows, about = read_table(copied / PATIENTS)
    rows = rows.assign(agent=rows["agent"].str.replace("slow", "fast"))
    write_table(rows, copied / PATIENTS, about)
    (copied / PAGE).write_text(tables.markdown(rows, about))
    assert check(copied, run=ONE).faults == ("fast_opening: is the label of what calls itself slow_opening",)
    path = copied / submission.read(copied).agents[1].copy_at
    path.write_text(path.read_text() + "\n# changed\n")
    assert check(copied, run=ONE).faults == ("opening_with_circles: its files have changed since it was played",)


def test_a_copy_that_links_to_itself_is_one_line(copied, capsys):
    path = copied / submission.read(copied).agents[1].copy_at
    path.unlink()
    path.symlink_to(path.name)
    assert path.name in refused(copied, capsys)


def test_many_scores_are_refused_at_once(copied, capsys):
    def many(data):
        data["scores"] = [data["scores"][0] | {"agent": f"a{i}"} for i in range(15_000)]

    changed(copied, many)
    began = time.monotonic()
    assert "scores" in refused(copied, capsys) and time.monotonic() - began < 5.0


@pytest.mark.parametrize("label", ["<img src=x onerror=alert(1)>", "a | 0.1", "[x](javascript:a)", "`", "x" * 61, "é"])
def test_a_label_of_other_signs_is_refused(copied, capsys, label):
    changed(copied, lambda data: data["agents"][0].update(agent=label))
    assert "allowed: printable letters, digits, blanks and ._-(), 60 at most" in refused(copied, capsys)


@pytest.mark.parametrize("score", [-1e9, 30.5, 1e300])
def test_a_score_outside_of_an_episode_is_refused(copied, capsys, score):
    changed(copied, lambda data: data["scores"][0].update(score_s=score))
    assert "hinge-exact: a score is" in refused(copied, capsys)


def test_a_link_out_of_the_submission_is_refused(copied, tmp_path, capsys):
    path = copied / submission.read(copied).agents[1].copy_at
    path.rename(tmp_path / "elsewhere.yaml")
    path.symlink_to(tmp_path / "elsewhere.yaml")
    assert "allowed: a path within agents/" in refused(copied, capsys)


def test_a_check_draws_patients_by_its_own_entropy_and_plays_the_parts_in_which_they_lie():
    parts = [object() for _ in range(10)]
    draws = [drawn(parts, 3, np.random.default_rng(seed)) for seed in (0, 0, 1)]
    assert draws[0] == draws[1] != draws[2] and 1 <= len(draws[0]) <= 3
    assert drawn(parts, None, np.random.default_rng(0)) == parts == drawn(parts, 5000, np.random.default_rng(0))
    counts = np.bincount([len(drawn(parts, 220, np.random.default_rng(seed))) for seed in range(100)])
    assert counts[:9].sum() == 0, "so many patients lie in nearly every part"


def table(patients=100):
    """Rows of one score, as of an honest agent."""
    random = np.random.default_rng(0)
    rows = pd.DataFrame({"task": "jaw-exact", "agent": "mine", "seed": range(patients)})
    return rows.assign(**{column: random.uniform(1.0, 20.0, patients) for column in COLUMNS[1:]}).assign(
        violated=False, completed=True
    )


STEP = {("jaw-exact", "mine"): 0.2}


def test_on_one_platform_the_last_bit_counts_in_every_column():
    rows = table()
    assert faults_of(rows, rows, None) == []
    rows["within_0.1_s"] = np.inf
    assert faults_of(rows, rows, None) == []
    for column in ("worst_sd", "nees", "claimed_s"):
        forgery = rows.assign(**{column: np.nextafter(rows[column], 0.0)})
        assert len(faults_of(forgery, rows, None)) == 1 and faults_of(forgery, rows, STEP) == []


@pytest.mark.parametrize("column", COLUMNS[1:])
@pytest.mark.parametrize("number", [20, 100])
def test_elsewhere_much_better_for_half_and_little_worse_for_the_others_is_found(column, number):
    rows = table(number)
    if rows[column].dtype == bool:
        return
    size = 0.2 if column.endswith("_s") and column != "discomfort_s" else 0.9 * LARGEST_SHARE * rows[column]
    better = np.arange(number) % 2 == 0
    forgery = rows.assign(**{column: np.where(better, rows[column] - size, rows[column] * (1.0 + 1e-5))})
    (fault,) = [line for line in faults_of(forgery, rows, STEP) if line.startswith("jaw-exact")]
    assert f"{column} differs by -" in fault and "on average" in fault


@pytest.mark.parametrize("column", ["score_s", "rmse", "within_0.05_s"])
def test_elsewhere_small_differences_are_allowed_unless_they_lean_one_way(column):
    rows = table()
    signs = np.random.default_rng(1).choice([-1.0, 1.0], len(rows))
    size = 0.2 if column.endswith("_s") else 0.9 * LARGEST_SHARE * rows[column]
    assert faults_of(rows.assign(**{column: rows[column] + signs * size}), rows, STEP) == []
    fault = faults_of(rows.assign(**{column: rows[column] - size}), rows, STEP)[0]
    assert f"{column} of 100 of 100 patients differs the same way" in fault
    assert "patients differs, as seed" in faults_of(rows.assign(**{column: rows[column] - 1.5 * size}), rows, STEP)[0]
