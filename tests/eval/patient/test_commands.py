"""``python -m eval patient`` as a user types it."""

import re
import sys
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from eval.commands.app import main
from eval.commands.patient import as_a_clinic
from eval.kept.entries import Settings, load_entries
from eval.patient import page
from eval.patient.courses import Person
from eval.patient.treatments import Course, first_treatment
from jawenv import MUSCLE_NAMES, Patient
from jawenv.anatomy import cohort
from jawenv.metrics.verdicts import UNKNOWN, verdicts
from tests.browser import executable, new_page
from tests.eval.report.test_page import Balance

RICH = "refined"
SHORT = ["--episode-s", "0.5", "--seed", "5200"]
HEALTHY, LEFT, BLOCKED = "healthy", "left_side", "blockage"


def patient(name, F_o=0.8, b=7.0, left_F_o=None):
    forces = {muscle: left_F_o if left_F_o and muscle.endswith("left") else F_o for muscle in MUSCLE_NAMES}
    return Patient(name=name, F_o_N=forces, b=dict.fromkeys(MUSCLE_NAMES, b))


def run(output, *arguments):
    known = () if "--knowledge" in arguments else ("--knowledge", "exact")
    return main(["patient", *arguments, *known, "--output", str(output)])


def test_a_patient_is_known_as_a_scan_shows_him_unless_something_else_is_said():
    assert as_a_clinic({"env": "Jaw"}) == {"env": "Jaw", "cohort": "anyone", "knowledge": "bench"}
    assert as_a_clinic({"env": "Jaw", "knowledge": "exact"})["knowledge"] == "exact"
    assert "knowledge" not in as_a_clinic({"env": "JawImaged"})


def words_of(text):
    """The text that a reader sees."""
    text = re.sub(r"<style>.*?</style>", " ", text, flags=re.S)
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", text))


@pytest.fixture(scope="module")
def three(tmp_path_factory):
    """Pages and verdicts of a healthy, a one-sided and a blocked patient, 8 s each."""
    folder = tmp_path_factory.mktemp("patients")
    given = [patient(HEALTHY), patient(LEFT, left_F_o=4.0), patient(BLOCKED, b=18.0)]
    options = []
    for one in given:
        one.save(folder / f"{one.name}.json")
        options += ["--patient", str(folder / f"{one.name}.json")]
    options += ["--cohort", "wide", "--control", "targets", "--episode-s", "12", "--seed", "5200"]
    assert run(folder, RICH, *options) == 0
    pages = {one.name: (folder / f"patient-{one.name}.html").read_text(encoding="utf-8") for one in given}
    return pages, pd.read_parquet(folder / "verdicts.parquet"), folder


@pytest.mark.parametrize(
    ("name", "headline"),
    [
        (HEALTHY, "All six closing muscles are normal."),
        (LEFT, "Stiff: all three on the left. Normal: all three on the right."),
        (BLOCKED, "All six closing muscles are blocked."),
    ],
)
def test_good_knowledge_gives_the_right_verdicts(three, name, headline):
    pages, table, _ = three
    assert headline in words_of(pages[name])
    own = table[table["patient"] == name]
    assert list(own["muscle"]) == list(MUSCLE_NAMES)
    assert (own["verdict"] == own["truly"]).all() and (own["probability"] >= 0.95).all()
    for row in own.to_dict("records"):
        assert row["F_o_N_low"] < row["F_o_N"] < row["F_o_N_high"]
        assert abs(np.log(row["F_o_N"] / row["F_o_N_true"])) < 0.2 and abs(np.log(row["b"] / row["b_true"])) < 0.2


def test_nothing_is_known_at_the_start(three):
    """Each treatment begins unknown, and a page of beliefs as wide as the prior says so."""
    _, _, folder = three
    settings = Settings.of(1, 5200, cohort="wide", control="targets", episode_s=12.0)
    (entry,) = load_entries([RICH], settings.world)
    population = cohort("wide").prior
    for name in (HEALTHY, LEFT, BLOCKED):
        played = first_treatment(entry, 5200, Patient.load(folder / f"{name}.json"))
        assert {each.word for each in verdicts(played.mean[0], played.cov[0])} == {UNKNOWN}
        unknown = replace(
            played,
            mean=np.broadcast_to(population.mean, played.mean.shape),
            cov=np.broadcast_to(np.diag(population.sd**2), played.cov.shape),
            misfit=0.0,
        )
        about = {"finished": "today", "command": "python -m eval patient"}
        subject = page.Subject.simulated(entry, Person("1", 5200), Course(), 30.0)
        text = words_of(page.render(subject, [unknown], about, show_truth=False))
        assert "Nothing can be said about any of the six closing muscles yet." in text
        said = "the error bars say little more than before"
        assert text.count(said) == len(MUSCLE_NAMES) and "probability above" not in text


def test_a_page_stands_alone_and_says_what_it_is(three):
    pages, _, _ = three
    for written in pages.values():
        parser = Balance()
        parser.feed(written)
        assert parser.open == [] and all(address.startswith("#") for address in parser.addresses)
        assert "<script" not in written and not re.search(r"@import|url\((?!#)", written) and len(written) < 400_000
        assert "prefers-color-scheme: dark" in written and "size: A4" in written
        text = words_of(written)
        assert "Research, not a medical device. The patient is simulated, the anatomy known" in text
        assert re.search(r"0\.\d{3} N 95 %: 0\.\d+ to [01]\.\d+", text)
        assert "true:" not in text and "truly" not in text
    assert "Can it be believed?" in pages[LEFT] and pages[LEFT].count("<svg") == 3 + 2 * len(MUSCLE_NAMES)


def test_the_truth_is_shown_where_it_is_asked_for(three, tmp_path):
    _, _, folder = three
    arguments = ["--patient", str(folder / f"{LEFT}.json"), "--cohort", "wide", *SHORT, "--show-truth"]
    assert run(tmp_path, RICH, *arguments) == 0
    text = words_of((tmp_path / f"patient-{LEFT}.html").read_text(encoding="utf-8"))
    assert text.count("truly stiff") == 3 and text.count("true: 4.00 N") == 3 and text.count("true: 7.00") == 6


def test_no_verdict_is_given_where_the_readings_do_not_fit_the_model(tmp_path, capsys):
    arguments = ["--episode-s", "8", "--seed", "5200", "--control", "targets", "--reality", "fossa_error=0.3"]
    assert run(tmp_path, "refined", *arguments) == 0
    text, said = words_of((tmp_path / "patient-5200.html").read_text(encoding="utf-8")), capsys.readouterr().out
    assert "No verdict: the readings do not fit the model." in text and "No verdict: the readings" in said
    assert "The numbers below are not to be trusted." in text
    assert "probability above" not in text and "most likely" not in text
    table = pd.read_parquet(tmp_path / "verdicts.parquet")
    assert set(table["verdict"]) == {"no verdict"} and (table["misfit"] > 1.0).all()
    assert table["probability"].isna().all()


def test_what_rang_once_leaves_no_verdict_to_later_treatments(three):
    _, _, folder = three
    (entry,) = load_entries([RICH], Settings.of(1, 5200, cohort="wide", control="targets", episode_s=12.0).world)
    good = first_treatment(entry, 5200, Patient.load(folder / f"{HEALTHY}.json"))
    assert not good.rings
    course = [good, replace(good, misfit=1.2), good]
    rows = (
        pd.DataFrame(page.verdict_rows(Person("1", 5200), course, cohort("wide").prior))
        .groupby("treatment")["verdict"]
        .first()
    )
    assert rows.tolist() == ["normal", "no verdict", "no verdict"]
    about = {"finished": "today", "command": "python -m eval patient"}
    subject = page.Subject.simulated(entry, Person("1", 5200), Course(3), 30.0)
    text = words_of(page.render(subject, course, about, show_truth=False))
    assert "do not fit the model in treatment 2:" in text


IMAGED = ["refined", "--episode-s", "2", "--seed", "5200", "--control", "targets", "--knowledge", "imaged"]


@pytest.fixture(scope="module")
def changed(tmp_path_factory):
    """Two treatments of a patient whose anatomy is not known exactly: the folder, and what the page says."""
    folder = tmp_path_factory.mktemp("changed")
    assert run(folder, *IMAGED, "--treatments", "2", "--drift", "0.1") == 0
    return folder, words_of((folder / "patient-5200.html").read_text(encoding="utf-8"))


def test_the_change_stands_beside_the_estimates_where_the_anatomy_is_not_known_exactly(changed, tmp_path):
    folder, text = changed
    told = re.findall(r"change: (softer|stiffer) by \d+ % \(−?\d+ … −?\d+\)", text)
    assert len(told) == 12 and "errors that come of the anatomy are alike in both" in text
    table = pd.read_parquet(folder / "verdicts.parquet")
    first, second = (table[table["treatment"] == number] for number in (1, 2))
    assert second["F_o_change"].between(second["F_o_change_low"], second["F_o_change_high"]).all()
    assert first["F_o_change"].isna().all() and second["b_change_low"].notna().all()
    assert run(tmp_path / "exact", *IMAGED[:-2], "--treatments", "2") == 0
    exact = pd.read_parquet(tmp_path / "exact" / "verdicts.parquet")
    assert exact["F_o_change"].isna().all()
    assert "change:" not in words_of((tmp_path / "exact" / "patient-5200.html").read_text(encoding="utf-8"))


@pytest.mark.parametrize("more", [("--treatments", "2", "--drift", "0.1"), ("--episode-s", "8")])
def test_a_page_with_all_that_it_can_hold_prints_on_one_sheet(changed, monkeypatch, more):
    folder, _ = changed
    executable()
    arguments = [*IMAGED, *more, "--show-truth"]
    monkeypatch.setattr(sys, "argv", ["eval", "patient", *arguments])  # which the page prints
    assert run(folder, *arguments) == 0
    page = new_page()
    page.goto((folder / "patient-5200.html").as_uri())
    sheet = page.pdf(prefer_css_page_size=True)
    page.context.close()
    assert len(re.findall(rb"/Type\s*/Page[^s]", sheet)) == 1


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["hold_still", "--treatments", "0"], "treatments is 0; allowed: 1 or more"),
        (["hold_still", "--drift", "nan"], "drift is nan; allowed: 0 to 0.5"),
        (["hold_still", "--patients", "0"], "patients is 0; allowed: 1 or more"),
        (["hold_still", "--env", "JawSides"], "env is jawenv/JawSides-v3; allowed: those with six"),
        (["hold_still", "--patient", "none.json"], "none.json: no such file"),
    ],
)
def test_bad_input_is_refused_in_one_line(arguments, told, tmp_path, capsys):
    assert run(tmp_path, *arguments) == 2
    error = capsys.readouterr().err
    assert told in error and error.count("\n") == 1
    assert not list(tmp_path.glob("*.html"))


def test_two_files_of_one_name_and_a_file_in_place_of_a_folder(tmp_path, capsys):
    patient(HEALTHY).save(tmp_path / "same.json")
    (tmp_path / "other").mkdir()
    patient(HEALTHY).save(tmp_path / "other" / "same.json")
    twice = ["--patient", str(tmp_path / "same.json"), "--patient", str(tmp_path / "other" / "same.json")]
    assert run(tmp_path, "hold_still", *SHORT, *twice) == 2
    assert "beside another file of that name" in capsys.readouterr().err
    assert run(tmp_path / "same.json", "hold_still", *SHORT) == 2
    assert "same.json" in capsys.readouterr().err
