"""The catalogue of figures, on rows of known outcome."""

import numpy as np
import pandas as pd
import pytest

from eval.figures import statistics
from eval.figures.catalogue import FIGURES, above_limit
from eval.report.template import with_terms
from tests.eval.studies import TRAINED, study


@pytest.fixture(scope="module")
def rows():
    return study(patients=12).of(TRAINED)


def test_every_figure_is_of_every_study(rows):
    for name, figure in FIGURES.items():
        assert len(figure.of(rows)) == len(rows), name
        assert np.isfinite(figure.interval(rows).value) or name.startswith("time_to"), name
        assert figure.title and "{" not in figure.title


def test_a_figure_is_unknown_where_it_is_not_of_one_patient(rows):
    short = rows.assign(early_worst_sd=[np.nan, *rows["early_worst_sd"][1:]])
    assert not FIGURES["early_worst_sd"].interval(short).exists
    assert np.isnan(FIGURES["early_worst_sd"].interval(short).value)


def test_means_and_quantiles_are_those_of_the_patients(rows):
    assert FIGURES["nees"].interval(rows) == statistics.mean(rows["nees"].to_numpy())
    assert FIGURES["nees_per_parameter"].interval(rows).value == pytest.approx(rows["nees"].mean() / 12)
    assert FIGURES["worst_sd_p90"].interval(rows) == statistics.quantile(rows["worst_sd"].to_numpy(), 0.9)
    assert FIGURES["worst_sd_max"].interval(rows).value == rows["worst_sd"].max()
    rate = 30.0 * rows["discomfort_s"].sum() / rows["duration_s"].sum()
    assert FIGURES["discomfort_rate"].interval(rows).value == pytest.approx(rate)


def test_errors_are_a_multiple_of_the_bound(rows):
    made = study(patients=12)
    expected = statistics.rmse_over_bound(made.array(TRAINED, "error"), made.array(TRAINED, "bound_sd"))
    assert FIGURES["rmse_over_bound"].interval(rows) == expected


def test_a_limit_of_comfort_may_be_another():
    rows = pd.DataFrame({"discomfort_s": [0.0, 0.3], "duration_s": [30.0, 30.0]})
    assert above_limit(0.2).of(rows).tolist() == [0.0, 1.0]
    assert above_limit(0.5).interval(rows).value == 0.0


def test_headings_explain_their_terms_and_are_texts():
    heading = with_terms("NEES\nof <b>sd</b>")
    assert heading.count("<abbr") == 2 and "<br>of &lt;b&gt;" in heading
