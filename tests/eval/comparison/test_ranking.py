import io

import numpy as np
import pytest
from rich.console import Console

from eval.comparison.ranking import rank
from eval.report import table, verdict, words
from eval.statistics import Interval
from jawenv.errors import InputError
from tests.eval.studies import BOASTFUL, GOOD, IDLE, TRAINED, study


@pytest.fixture(scope="module")
def made():
    return study()


@pytest.fixture(scope="module")
def ranking(made):
    return rank(made)


def test_entries_are_ordered_by_true_information(ranking):
    assert [row.entry for row in ranking.rows] == [GOOD, TRAINED, BOASTFUL, IDLE]
    assert ranking.reference == GOOD


def test_claims_do_not_help(ranking):
    claimed = {row.entry: row.information_claimed.value for row in ranking.rows}
    assert claimed[BOASTFUL] > claimed[TRAINED]


def test_differences_are_paired(made, ranking):
    row = ranking.rows[1]
    gained = made.of(TRAINED)["information_true"].to_numpy() - made.of(GOOD)["information_true"].to_numpy()
    assert row.difference.value == pytest.approx(gained.mean())
    assert ranking.rows[0].difference is None


def test_another_reference_turns_the_differences_round(made, ranking):
    turned = rank(made, TRAINED)
    assert turned.rows[0].difference.value == pytest.approx(-ranking.rows[1].difference.value)


def test_an_unknown_reference_is_named(made):
    with pytest.raises(InputError, match="reference: 'nobody' given, allowed are good_one"):
        rank(made, "nobody")


def test_calibration_is_judged_by_the_band(ranking):
    kinds = {row.entry: ranking.calibration(row) for row in ranking.rows}
    assert kinds == {GOOD: "honest", TRAINED: "honest", BOASTFUL: "overconfident", IDLE: "honest"}


def test_the_verdict_says_who_wins_who_lies_and_who_hurts(ranking):
    assert verdict.headline(ranking).startswith("The 12 parameters of jawenv/Jaw-v1 are identified best by good one.")
    told = " ".join(verdict.remarks(ranking))
    assert "The trained agent ppo-seed0 is number 2 of 4" in told
    assert "less than good one" in told
    assert "Ahead of it: good one" in told
    assert "Overconfident: boastful" in told
    assert "No hard comfort limit was crossed" in told


def test_few_patients_are_said_to_be_few():
    assert "Only 5 patients" in " ".join(verdict.remarks(rank(study(patients=5))))
    assert "One patient only" in " ".join(verdict.remarks(rank(study(patients=1))))


def test_the_terminal_shows_calibration_beside_every_sd(ranking):
    console = Console(file=io.StringIO(), width=120)
    table.show(ranking, console)
    lines = console.file.getvalue().splitlines()
    boastful = next(line for line in lines if "boastful" in line)
    assert "too small" in boastful
    assert words.percent(ranking.rows[2].worst_sd_median.value) in boastful


def test_numbers_are_written_for_people():
    assert words.number(-2.345) == "\N{MINUS SIGN}2.3"
    assert words.number(-0.01) == "0.0"
    assert words.number(np.inf) == "never"
    assert words.number(np.nan) == words.NOTHING
    assert words.interval(Interval(1.0, 0.5, np.inf)) == "0.5 … never"
    assert words.interval(Interval(1.0, np.nan, np.nan)) == ""
