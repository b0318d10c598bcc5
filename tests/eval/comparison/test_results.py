import numpy as np
import pandas as pd
import pytest

from eval.comparison import results
from eval.rows.outcomes import EARLY_METRICS, outcomes_of
from tests.eval.studies import BOASTFUL, GOOD, study
from tests.metrics.linear_gaussian import linear_gaussian


@pytest.fixture(scope="module")
def made():
    return study(patients=6)


def test_tables_come_back_as_they_were_saved(made, tmp_path):
    results.save(made, tmp_path)
    read = results.load(tmp_path)
    pd.testing.assert_frame_equal(read.patients, made.patients)
    pd.testing.assert_frame_equal(read.curves, made.curves)
    assert read.about == made.about


def test_a_row_per_patient_and_entry(made):
    assert len(made.patients) == 6 * 4
    assert made.of(GOOD)["seed"].tolist() == [7, 8, 9, 10, 11, 12]
    assert made.array(GOOD, "truth").shape == (6, 12)
    np.testing.assert_array_equal(made.array(GOOD, "truth"), made.array(BOASTFUL, "truth"))


def test_what_is_known_early_is_what_an_episode_that_ends_then_has(made):
    lasts_10_s = outcomes_of(linear_gaussian(3, steps=20), 7)
    for name in EARLY_METRICS:
        np.testing.assert_allclose(lasts_10_s[name], lasts_10_s[name.removeprefix("early_")], rtol=1e-9)
        assert outcomes_of(linear_gaussian(3, steps=19), 7)[name].isna().all()
    assert (made.of(GOOD)["early_worst_sd"] > made.of(GOOD)["worst_sd"]).all()


def test_curves_end_where_the_patients_do(made):
    curves = made.curves[(made.curves["entry"] == GOOD) & (made.curves["quantity"] == "worst_sd")]
    assert curves["time_s"].iloc[-1] == 20.0
    assert curves["centre"].iloc[-1] == pytest.approx(made.of(GOOD)["worst_sd"].median())
    assert (curves["low"] <= curves["high"]).all()
