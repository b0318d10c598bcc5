import io

import numpy as np
import pytest
from rich.console import Console

from eval.comparison.admission import AdmissionLimits
from eval.comparison.ranking import CLAIRVOYANT, KNOWN, SOON, rank
from eval.figures import words
from eval.figures.catalogue import DIFFERENCE
from eval.figures.statistics import Interval
from eval.report import first, table
from jawenv.metrics import nees_band
from tests.eval.studies import BOASTFUL, GOOD, IDLE, TRAINED, study


@pytest.fixture(scope="module")
def made():
    return study()


@pytest.fixture(scope="module")
def ranking(made):
    return rank(made)


def test_what_costs_too_much_stands_below_with_its_reason(made, ranking):
    assert [row.entry for row in ranking.ranked] == [GOOD, IDLE]
    hurtful, boastful = ranking.others
    assert (hurtful.entry, boastful.entry) == (TRAINED, BOASTFUL)
    assert boastful.excluded == "sds are false: errors are 2.2 times what the filter states"
    assert hurtful.excluded == "discomfort 6 s per 30 s, allowed 0.1"
    assert hurtful["discomfort_rate"].value == pytest.approx(30.0 / 20.0 * made.of(TRAINED)["discomfort_s"].mean())
    assert [ranking.mark(row) for row in ranking.rows] == ["1", "2", "a", "b"]


def test_a_patient_one_may_hurt_more(made):
    ranking = rank(made, admission=AdmissionLimits(discomfort_s=6.5))
    assert [row.entry for row in ranking.ranked] == [GOOD, TRAINED, IDLE]


def test_the_first_is_who_knows_all_soonest_and_among_equals_who_knows_most(made, ranking):
    soon = [(row[SOON].value, row[f"{SOON}_p90"].value) for row in ranking.ranked]
    assert soon == sorted(soon)
    seconds = made.of(GOOD)[f"time_to_{KNOWN:g}_s"].to_numpy()
    row = next(row for row in ranking.rows if row.entry == GOOD)
    assert row[f"{SOON}_p90"].value == np.quantile(seconds, 0.9, method="inverted_cdf")
    never = made.patients.assign(**{f"time_to_{KNOWN:g}_s": np.inf})
    equal = rank(type(made)(never, made.curves, made.about), admission=AdmissionLimits(discomfort_s=9.0))
    truth = [row["information_true"].value for row in equal.ranked]
    assert len(truth) == 3
    assert truth == sorted(truth, reverse=True)


def test_who_crosses_hard_limits_is_not_ranked(made):
    hurt = made.patients.copy()
    hurt.loc[(hurt["entry"] == GOOD) & (hurt["patient"] == 0), "violated"] = True
    study = type(made)(hurt, made.curves, made.about)
    reasons = {row.entry: row.excluded for row in rank(study).others}
    assert reasons[GOOD] == "2.5 % of the episodes cross a hard limit, allowed 1.0 %"
    assert GOOD not in {row.entry for row in rank(study, admission=AdmissionLimits(violation=0.03)).others}


def ringing(made, entry, patients):
    """The study in which the alarm rings for so many patients of an entry."""
    table = made.patients.copy()
    table.loc[(table["entry"] == entry) & (table["patient"] < patients), "misfit"] = 3.0
    return type(made)(table, made.curves, made.about)


def test_nothing_is_known_by_readings_that_do_not_fit_the_model(made):
    ranking = rank(ringing(made, GOOD, 3))
    assert [row.entry for row in ranking.rows] == [IDLE, TRAINED, BOASTFUL, GOOD]
    last = ranking.rows[-1]
    assert ranking.mark(last) == "c" and last["rings"].value == pytest.approx(3 / 40)
    assert last.excluded == (
        "the alarm rings in 7.5 % of the episodes, allowed 5 %: their readings do not fit the model"
    )
    console = Console(file=io.StringIO(), width=120)
    table.show(ranking, console)
    assert "not ranked: the alarm rings in 7.5 %" in " ".join(console.file.getvalue().split())


def test_what_is_asked_for_is_named(made):
    about = made.about | {"settings": made.about["settings"] | {"asked": "random"}}
    ranking = rank(type(made)(made.patients, made.curves, about))
    assert "the parameters asked for are within" in first.answer(ranking)
    assert "all 12 parameters are within" in first.answer(rank(made))


def test_few_may_ring(made):
    ranking = rank(ringing(made, GOOD, 2))
    assert ranking.ranked[0].entry == GOOD


def test_who_sees_the_truth_is_a_yardstick(made):
    entries = [each | {"clairvoyant": each["label"] == GOOD} for each in made.about["entries"]]
    ranking = rank(type(made)(made.patients, made.curves, made.about | {"entries": entries}))
    assert next(row for row in ranking.others if row.entry == GOOD).excluded == CLAIRVOYANT


def misled(made, factor):
    """The study with errors that are so many times as large, as if by an effect that the filter does not know."""
    patients = made.patients.copy()
    before = patients["nees"].copy()
    patients["nees"] *= factor**2
    patients["information_true"] -= 0.5 * (patients["nees"] - before)
    patients["honesty_gap"] += 0.5 * (patients["nees"] - before)
    about = made.about | {"settings": made.about["settings"] | {"reality": {"creep_share": 0.3}}}
    return type(made)(patients, made.curves, about)


def test_false_sds_identify_nothing(made):
    ranking = rank(misled(made, 12.0))
    assert not ranking.ranked
    assert not ranking.believed
    assert first.answer(ranking).startswith("With creep_share = 0.3, unknown to the filter: No maneuver id")
    assert all("sds are false" in row.excluded for row in ranking.rows)


def test_the_band_allows_for_the_number_of_entries(ranking):
    assert ranking.band == nees_band(40, 12, 1.0 - 0.05 / 4)


def test_differences_are_paired(made, ranking):
    assert ranking.reference == ranking.rows[0].entry == GOOD
    assert DIFFERENCE not in ranking.rows[0].figures
    row = next(row for row in ranking.rows if row.entry == TRAINED)
    gained = made.of(TRAINED)["information_true"].to_numpy() - made.of(GOOD)["information_true"].to_numpy()
    assert row[DIFFERENCE].value == pytest.approx(gained.mean())


def test_another_reference_turns_the_differences_round(made, ranking):
    turned = rank(made, TRAINED)
    before = next(row for row in ranking.rows if row.entry == TRAINED)
    assert turned.rows[0][DIFFERENCE].value == pytest.approx(-before[DIFFERENCE].value)


def test_calibration_is_judged_by_the_band(ranking):
    kinds = {row.entry: ranking.calibration(row) for row in ranking.rows}
    assert kinds == {GOOD: "calibrated", TRAINED: "calibrated", BOASTFUL: "overconfident", IDLE: "calibrated"}


def test_the_terminal_shows_calibration_beside_every_sd(ranking):
    console = Console(file=io.StringIO(), width=120)
    table.show(ranking, console)
    lines = console.file.getvalue().splitlines()
    assert any("boastful" in line and "too small" in line for line in lines)
    assert next(line for line in lines if "ppo-seed0" in line).split()[0] == "a"
    assert any("not ranked: discomfort 6 s per 30 s" in line for line in lines)


def test_numbers_are_written_for_people():
    assert words.number(-2.345) == "\N{MINUS SIGN}2.3"
    assert words.number(-0.01) == "0.0"
    assert words.number(np.inf) == "never"
    assert words.number(np.nan) == words.NOTHING
    assert words.interval(Interval(1.0, 0.5, np.inf)) == "0.5 … never"
    assert words.interval(Interval(1.0, np.nan, np.nan)) == ""
