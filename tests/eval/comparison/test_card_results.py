"""From a comparison to the figures of a model card."""

import numpy as np
import pytest

from eval.comparison import results
from eval.comparison.card_results import card_results, results_of_run
from jawenv.base.errors import InputError
from tests.eval.studies import GOOD, TRAINED, study


def test_figures_are_those_of_the_entry() -> None:
    made = study()
    reached = {result.metric: result for result in card_results(made, GOOD)}
    rows = made.of(GOOD)
    assert set(reached) == {
        "largest of 12 sds after 10 s, %",
        "largest of 12 sds after 20 s, %",
        "true information after 20 s, nats",
        "discomfort in 20 s, s",
        "NEES after 20 s, 12 if calibrated",
    }
    early, nees = reached["largest of 12 sds after 10 s, %"], reached["NEES after 20 s, 12 if calibrated"]
    assert early.mean is None and early.median == pytest.approx(100 * np.median(rows["early_worst_sd"]), rel=0.02)
    assert nees.median is None and nees.mean == pytest.approx(rows["nees"].mean(), abs=1e-3)
    assert early.low < early.median < early.high and nees.low < nees.mean < nees.high
    assert {(result.cohort, result.patients, result.seeds) for result in reached.values()} == {("trismus", 40, (7, 46))}


def test_an_episode_of_ten_seconds_is_told_once() -> None:
    made = study()
    made.about["settings"]["episode_s"] = 10.0
    told = [result.metric for result in card_results(made, GOOD)]
    assert len(set(told)) == len(told) == 4


def test_a_run_is_found_by_its_folder(tmp_path) -> None:
    made, run = study(), tmp_path / "runs" / "agent"
    entries = [each | ({"spec": str(run)} if each["label"] == TRAINED else {}) for each in made.about["entries"]]
    results.save(type(made)(made.patients, made.curves, made.about | {"entries": entries}), tmp_path)
    assert results_of_run(tmp_path, run) == card_results(results.load(tmp_path), TRAINED)
    with pytest.raises(InputError, match="other: not in this comparison; allowed: "):
        results_of_run(tmp_path, tmp_path / "other")
    with pytest.raises(InputError):
        card_results(study(1), GOOD)
