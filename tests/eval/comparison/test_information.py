"""The command: its table, what it keeps, and what it refuses."""

import numpy as np
import pandas as pd
import pytest

from eval.commands.app import main
from eval.kept import entries
from eval.kept.tables import read_table
from eval.rows.gains import _law_of
from jawenv.envs.configuration import Configuration
from jawenv.inference import patient_law

SMALL = ("--env", "JawHinge", "--patients", "6", "--episode-s", "1", "--workers", "1")


def play(output, *arguments):
    return main(
        [
            "information",
            *(arguments or ("slow_opening", "refined", "--contrasts", "4")),
            *SMALL,
            "--output",
            str(output),
        ]
    )


@pytest.fixture(autouse=True)
def few_draws(monkeypatch):
    of = patient_law.PatientLaw.of
    monkeypatch.setattr(patient_law.PatientLaw, "of", lambda *given, **kwargs: of(*given, **kwargs, draws=300))
    _law_of.cache_clear()
    yield
    _law_of.cache_clear()


def test_a_row_per_design_and_patient(tmp_path, plays, capsys):
    assert play(tmp_path) == 0
    rows, about = read_table(tmp_path / "patients.parquet")
    assert list(rows["seed"]) == [*range(6)] * 2 and about["contrasts"] == 4
    table = pd.read_parquet(tmp_path / "information.parquet")
    assert list(table["entry"]) == ["slow_opening", "refined"]
    slow, refined = (rows[rows["entry"] == entry] for entry in table["entry"])
    assert refined["lower"].mean() > slow["lower"].mean() + 1.0
    assert table["lower"].tolist() == [slow["lower"].mean(), refined["lower"].mean()]
    assert table["lower_error"][0] == pytest.approx(slow["lower"].std() / np.sqrt(6))
    page = (tmp_path / "information.md").read_text()
    assert "| slow opening | 6 | " in page and "python -m eval" in page and "Expected information gain" in page
    assert plays.names == ["slow_opening"] * 2 + ["refined"] * 2 and plays.seeds == [0, 5, 0, 5]
    assert play(tmp_path) == 0 and len(plays.names) == 4
    assert "12 of 12 records kept" in capsys.readouterr().out


def test_the_bound_of_the_belief_is_the_true_information_from_the_law_on(tmp_path, monkeypatch):
    """It differs from the log score only by the entropy of the law in place of the prior's density"""
    kept, counted = [], entries.play

    def keep(*given, **kwargs):
        kept.append(counted(*given, **kwargs))
        return kept[-1]

    monkeypatch.setattr(entries, "play", keep)
    assert play(tmp_path, "refined", "--contrasts", "0") == 0
    rows = read_table(tmp_path / "patients.parquet")[0]
    law = _law_of(Configuration.from_mapping({"env": "hinge"}))
    prior = kept[0]
    for i, row in rows[:5].iterrows():
        z = (prior.truth[i] - prior.prior_mean) / prior.prior_sd
        density = -0.5 * (z**2).sum() - np.log(prior.prior_sd * np.sqrt(2.0 * np.pi)).sum()
        score = prior.at_end(prior.information_true)[i]
        assert row["posterior"] == pytest.approx(score + density + law.entropy, abs=1e-6)
        assert np.isnan(row["lower"]) and row["effective"] == 0.0


def test_what_is_refused(tmp_path, capsys):
    for arguments, said in (
        ((), "nothing to play"),
        (("refined", "--contrasts", "-1"), "contrasts is -1; allowed"),
        (("refined", "--patients", "0"), "patients is 0; allowed"),
    ):
        assert main(["information", *arguments, "--output", str(tmp_path)]) == 2
        assert said in capsys.readouterr().err
