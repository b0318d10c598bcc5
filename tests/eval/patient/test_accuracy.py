"""Sensitivity, specificity and both errors of verdicts, against counts by hand."""

import numpy as np
import pytest

from eval.figures.statistics import share, share_of_muscles
from eval.patient.accuracy import ALL, SHARES, accuracy, markdown
from jawenv.metrics.diagnosis import FIBROSED_F_O_N
from tests.eval.studies import GOOD, IDLE, study


@pytest.fixture(scope="module")
def made():
    return study(patients=60)


@pytest.fixture(scope="module")
def table(made):
    return accuracy(made)


def test_shares_are_counts(made, table):
    truth, error, sd = (made.array(GOOD, name)[:, 0::2] for name in ("truth", "error", "sd"))
    limit = np.log(FIBROSED_F_O_N)
    above = (truth + error - limit) / sd
    up, down, raised = above > 1.6448536, above < -1.6448536, truth > limit
    rows = table[(table["entry"] == GOOD) & (table["property"] == "stiff")].set_index("muscle")
    assert list(rows["raised"]) == [raised.sum(), *raised.sum(axis=0)]
    for name, hits, among in (
        ("sensitivity", up, raised),
        ("false_normal", down, raised),
        ("specificity", down, ~raised),
        ("false_raised", up, ~raised),
        ("undecided", ~(up | down), np.ones_like(raised)),
    ):
        expected = [hits[among].mean(), *(hits[:, i][among[:, i]].mean() for i in range(hits.shape[1]))]
        np.testing.assert_allclose(rows[name], expected, atol=1e-12)
        assert (rows[f"{name}_low"] <= rows[name] + 1e-12).all() and (rows[name] <= rows[f"{name}_high"] + 1e-12).all()


def test_they_are_those_of_the_report(made, table):
    whole = table[table["muscle"] == ALL].set_index(["entry", "property"])
    for entry in made.entries:
        for name, (limit, diagnosis) in made.diagnoses(entry).items():
            found = whole.loc[(entry, name)]
            assert found["above"] == limit
            assert found["sensitivity"] == pytest.approx(diagnosis.sensitivity, nan_ok=True)
            assert found["specificity"] == pytest.approx(diagnosis.specificity, nan_ok=True)
            assert found["undecided"] == pytest.approx(diagnosis.undecided)


def test_who_knows_little_decides_little(table):
    whole = table[(table["muscle"] == ALL) & (table["property"] == "stiff")].set_index("entry")
    assert whole.loc[IDLE, "undecided"] > whole.loc[GOOD, "undecided"]


def test_intervals_are_wider_where_the_muscles_of_a_patient_agree(rng):
    lone = rng.random((200, 6)) < 0.7
    alike = np.repeat(rng.random((200, 1)) < 0.7, 6, axis=1)
    counted = np.ones((200, 6), dtype=bool)
    narrow, wide = share_of_muscles(lone, counted), share_of_muscles(alike, counted)
    assert 1.8 < (wide.high - wide.low) / (narrow.high - narrow.low) < 3.2  # the root of 6 is 2.4
    perfect = share_of_muscles(counted, counted)
    assert perfect == share(np.ones(200, dtype=bool)) and perfect.low == pytest.approx(0.9811, abs=1e-3)
    assert np.isnan(share_of_muscles(counted, ~counted).value)


def test_a_markdown_table_for_each_entry_and_property(made, table):
    text = markdown(table, "lead")
    assert text.count("## ") == 2 * len(made.entries)
    lines = [line for line in text.splitlines() if line.startswith("|")]
    assert len({line.count("|") for line in lines}) == 1
    assert all(name in text for name in SHARES.values()) and "nan" not in text
