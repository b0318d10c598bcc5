"""From a comparison to the figures of a model card."""

import numpy as np
import pytest

from eval.commands.app import main
from eval.comparison import results
from eval.comparison.card_results import card_results
from jawenv.base.errors import InputError
from jawenv.base.files import read_model
from jawenv.playing.policies.card import ResultsFile
from tests.eval.studies import GOOD, TRAINED, study


def test_figures_are_those_of_the_entry() -> None:
    made = study()
    reached = {result.metric: result for result in card_results(made, GOOD).results}
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
    told = [result.metric for result in card_results(made, GOOD).results]
    assert len(set(told)) == len(told) == 4


def test_the_command_writes_what_an_export_reads(tmp_path, capsys) -> None:
    results.save(study(), tmp_path)
    output = tmp_path / "reached.json"
    assert main(["card", str(tmp_path), TRAINED, "--output", str(output)]) == 0
    assert read_model(output, ResultsFile) == card_results(results.load(tmp_path), TRAINED)
    printed = capsys.readouterr().out
    assert "NEES after 20 s, 12 if calibrated: mean 1" in printed and f"written: {output}" in printed


def test_what_cannot_be_told_is_named(tmp_path, capsys) -> None:
    results.save(study(), tmp_path)
    assert main(["card", str(tmp_path), "nobody"]) == 2
    assert "entry 'nobody': not in this comparison; allowed: good_one" in capsys.readouterr().err
    with pytest.raises(InputError):
        card_results(study(1), GOOD)
