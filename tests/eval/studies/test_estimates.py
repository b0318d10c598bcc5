"""Figures of studies whose rows are known."""

import numpy as np
import pandas as pd
import pytest

from eval.figures.catalogue import FIGURES
from eval.studies import estimates, tables
from eval.studies.design import Design
from eval.studies.grid import FACTORS

PATIENTS = 30


def design(**changes):
    given = {
        "title": "Known",
        "entries": ["good", "bad"],
        "controls": ["force", "targets"],
        "patients": PATIENTS,
        "seed": 5000,
        "episode_s": 10.0,
        "metrics": ["information_true", "worst_sd", "time_to_5", "nees_per_parameter"],
        "pairs": [["good", "bad"]],
    }
    return Design(**(given | changes))


def rows(rng, effect=1.0):
    """The patients differ much, the entries by `effect` in everything."""
    truth = rng.normal(size=PATIENTS)
    parts = []
    for control, hz in (("force", 20.0), ("targets", 5.0)):
        for entry, better in (("good", effect), ("bad", 0.0)):
            information = 50.0 + 10.0 * truth + better + 0.1 * rng.normal(size=PATIENTS)
            part = pd.DataFrame(
                {
                    "seed": 5000 + np.arange(PATIENTS),
                    "information_true": information,
                    "worst_sd": np.exp(-information / 20.0),
                    "time_to_0.05_s": np.where(np.arange(PATIENTS) < 20, 60.0 / information, np.inf),
                    "nees": np.full(PATIENTS, 2.0),
                    "truth/log_F_o/closers": truth,
                    "truth/log_b/closers": -truth,
                }
            )
            levels = ("JawHinge", "trismus", control, "pose", "cell", "none", hz, entry)
            parts.append(part.assign(**dict(zip(FACTORS, levels, strict=True))))
    return pd.concat(parts, ignore_index=True)


def test_cells_are_means_and_medians_of_their_rows(rng):
    known, wanted = rows(rng), design()
    table = estimates.cells(known, wanted).set_index(["control", "entry", "metric"])
    assert len(table) == 2 * 2 * 4
    own = known[(known["control"] == "force") & (known["entry"] == "good")]
    row = table.loc[("force", "good", "information_true")]
    assert row["value"] == pytest.approx(own["information_true"].mean()) and row["low"] < row["value"] < row["high"]
    assert table.loc[("force", "good", "nees_per_parameter"), "value"] == 1.0, "two parameters"
    middle = np.quantile(own["worst_sd"], 0.5, method="inverted_cdf")
    assert table.loc[("force", "good", "worst_sd"), "value"] == middle
    assert (table["patients"] == PATIENTS).all()


def test_a_metric_may_be_what_nine_of_ten_patients_reach(rng):
    known, wanted = rows(rng), design(metrics=["time_to_5", "worst_sd_p90", "time_to_5_p90", "reaches_5"])
    table = estimates.cells(known, wanted).query("control == 'force' and entry == 'good'").set_index("metric")["value"]
    own = known[(known["control"] == "force") & (known["entry"] == "good")]
    assert table["worst_sd_p90"] == np.quantile(own["worst_sd"], 0.9, method="inverted_cdf")
    assert np.isfinite(table["time_to_5"]) and np.isinf(table["time_to_5_p90"]), "20 of 30 patients get there"
    assert table["reaches_5"] == pytest.approx(20 / 30)
    assert set(estimates.pairs(known, wanted)["metric"]) == {"time_to_5", "reaches_5"}


def test_a_pair_is_compared_patient_by_patient_in_every_setting_and_over_all(rng):
    table = estimates.pairs(rows(rng), design()).set_index(["metric", "control"])
    information = table.loc["information_true"]
    assert list(information.index) == ["force", "targets", estimates.ALL]
    for _, row in information.iterrows():
        assert row["difference_low"] < 1.0 < row["difference_high"]
        assert row["difference_high"] - row["difference_low"] < 0.2, "what patients have in common cancels"
        assert row["probability"] == 1.0 and row["patients"] == PATIENTS
    sure = information["difference_high"] - information["difference_low"]
    assert sure[estimates.ALL] < min(sure["force"], sure["targets"])
    times = table.loc[("time_to_5", "force")]
    assert np.isnan(times["difference"]) and times["probability"] == pytest.approx((20 + 10 / 2) / 30)
    assert np.isnan(table.loc[("nees_per_parameter", "force"), "probability"])


def test_no_difference_is_none(rng):
    row = estimates.pairs(rows(rng, effect=0.0), design()).iloc[0]
    assert row["difference_low"] < 0.0 < row["difference_high"]
    assert row["probability_low"] < 0.5 < row["probability_high"]


def test_a_pair_of_settings_differs_in_the_rate_of_its_controls(rng):
    table = estimates.pairs(rows(rng), design(pairs=[[{"control": "force"}, {"control": "targets"}]]))
    assert set(table["entry"]) == {"good", "bad", estimates.ALL}
    assert (table["control"] == "").all() and (table["control_hz"] == "").all()


def test_only_the_same_patients_are_compared(rng):
    known = rows(rng)
    other = (known["entry"] == "bad") & (known["control"] == "force") & (known["seed"] == 5003)
    known.loc[other, "truth/log_b/closers"] += 1.0
    table = estimates.pairs(known, design()).set_index(["metric", "control"])["patients"]
    assert table["information_true"].to_list() == [PATIENTS - 1, PATIENTS, PATIENTS - 1]


def test_the_page_names_how_it_was_made(rng):
    known, wanted = rows(rng), design()
    about = {
        "command": "python -m eval study known.yaml",
        "finished": "2030-01-01 00:00 UTC",
        "versions": {"jawenv": "0.1.0"},
        "git": {"commit": "0123456789abcdef", "changed": True},
        "machine": {"cores": 2, "processor": "Some"},
    }
    figures = (function(known, wanted) for function in (estimates.cells, estimates.pairs))
    page = tables.markdown(*figures, wanted, about)
    assert "`python -m eval study known.yaml`" in page and "(seeds 5000–5029)" in page
    assert "2 cores of Some" in page and "commit 0123456789ab with changes" in page
    assert "environment JawHinge, cohort trismus" in page and "| environment |" not in page
    heads = [line for line in page.splitlines() if line.startswith("| ")]
    assert len(heads) == (1 + 4) + (1 + 1)


def test_patients_above_the_admitted_discomfort_are_counted_per_30_s():
    rows = pd.DataFrame({"discomfort_s": [0.0, 0.03, 0.04, 0.09], "duration_s": [10.0, 10.0, 10.0, 30.0]})
    np.testing.assert_array_equal(FIGURES["above_limit"].of(rows), [0.0, 0.0, 1.0, 0.0])
