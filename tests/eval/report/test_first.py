"""What a newcomer sees first."""

import io

import pytest
from rich.console import Console

from eval.comparison.ranking import rank
from eval.report import first, table
from eval.report.charts import entries
from tests.eval.studies import BOASTFUL, GOOD, IDLE, many_entries, study


@pytest.fixture(scope="module")
def made():
    return study(patients=12)


def test_the_best_five_and_those_of_ones_own_come_first():
    ranking = rank(many_entries())
    assert [row.entry for row in first.firsts(ranking)] == ["no_1", "no_2", "no_3", "no_4", "no_5", "my_own"]
    assert [row.entry for row in first.rest(ranking)] == [f"no_{k}" for k in range(6, 12)]


def test_a_replay_is_not_ones_own():
    made = many_entries()
    about = made.about | {"entries": [each | {"replay_of": "x"} for each in made.about["entries"]]}
    assert not any(row.own for row in rank(type(made)(made.patients, made.curves, about)).rows)


def test_the_answer_names_the_best_both_targets_and_the_patients(made):
    said = first.answer(rank(made))
    assert said.startswith("The best is good one: in half of the 12 patients, all 12 parameters are within 10 %")
    assert " s, within 5 % after " in said


def test_the_best_is_believed_by_its_nees_and_its_alarm(made):
    believed, because = first.belief(rank(made))
    assert believed and "the NEES of good one is" in because and "rings in 0 %" in because
    only = made.patients[made.patients["entry"] == BOASTFUL]
    assert not first.belief(rank(type(made)(only, made.curves, made.about)))[0]
    ringing = first.belief(rank(type(made)(made.patients.assign(misfit=3.0), made.curves, made.about)))
    assert not ringing[0] and "the alarm rings in 100 % of the episodes" in ringing[1]


def test_the_best_is_the_first_that_can_be_believed_or_nobody(made):
    """Twice the errors of who is ahead: ranked, since they are not false, and not called best."""
    patients = made.patients.copy()
    patients.loc[patients["entry"] == GOOD, "nees"] *= 2.0
    ranking = rank(type(made)(patients, made.curves, made.about))
    assert ranking.ranked[0].entry == GOOD and ranking.best.entry == IDLE
    assert first.answer(ranking).startswith("The best is hold still") and first.belief(ranking)[0]
    patients["nees"] = 20.0
    nobody = rank(type(made)(patients, made.curves, made.about))
    assert nobody.best is None and "cannot be believed" in first.answer(nobody)
    assert not first.belief(nobody)[0]


def test_the_terminal_shows_one_short_table_and_the_verdict():
    ranking, console = rank(many_entries()), Console(file=io.StringIO(), width=100)
    table.show(ranking, console)
    table.show_verdict(ranking, console)
    lines = [line.rstrip() for line in console.file.getvalue().splitlines()]
    assert len(lines) < 20
    assert any("my own" in line for line in lines) and not any("no 6" in line for line in lines)
    assert "6 more entries: in the report" in lines
    assert lines[-2].startswith("The best is no 1: ")
    assert lines[-1].startswith("Can it be believed? Yes, because the NEES of no 1 is ")


def test_entries_of_one_colour_differ_in_dash_and_in_marker():
    looks = entries(rank(many_entries()))
    assert looks[0]["colour"] == looks[9]["colour"]
    assert looks[0]["dash"] != looks[9]["dash"] and looks[0]["symbol"] != looks[9]["symbol"]
    assert len({(each["colour"], each["dash"]) for each in looks}) == len(looks)
