"""The answer of ``jawenv identify`` on a patient of whom nothing is known."""

import json
from functools import cache

import numpy as np
import pytest

import jawenv
from agents import load_agent
from jawenv.commands.app import main
from jawenv.recordings.defaults import BENCH
from jawenv.recordings.files import load_record, save_record

LABELS = ("prior_mean", "prior_sd", "knowledge", "truth", "start_mean", "start_sd")


@cache
def played(cohort, maneuver="opening_with_swings_and_fore_aft", seconds=10.0):
    world = {"record": True, "episode_s": seconds, "cohort": cohort}
    return jawenv.play(load_agent(maneuver), patients=1, seed=7000, env_kwargs=world).records[0]


def without_labels(record, path):
    """The file as a bench writes it, which knows neither patient nor truth."""
    save_record(record, path)
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    path.write_text("".join(line for line in lines if not line.startswith(tuple(f"# {name}:" for name in LABELS))))
    return path


@pytest.mark.parametrize("cohort", ["healthy", "severe"])
def test_a_file_without_a_label_is_of_anyone_with_a_scans_anatomy(cohort, tmp_path, capsys):
    path, answer = without_labels(played(cohort), tmp_path / "bench.csv"), tmp_path / "answer.json"
    assert main(["identify", str(path), "--json", str(answer)]) == 0
    said = capsys.readouterr().out
    assert "patient: anyone (F_o 0.38–18 N) · anatomy: the table's · head upright" in said
    found = json.loads(answer.read_text(encoding="utf-8"))
    assert found["believed"] is True and found["doubts"] == []
    assert found["assumed"]["cohort"] == "anyone" and found["assumed"]["head_tilt_deg"] == 0.0
    assert found["assumed"]["knowledge"]["attachments"] > 0.0
    assert set(found["verdicts"]) == set(jawenv.MUSCLE_NAMES)
    error, cov = np.array(found["log_mean"]) - played(cohort).truth, np.array(found["log_cov"])
    assert cov.shape == (12, 12) and error @ np.linalg.solve(cov, error) < 40.0
    assert found["parameter_names"] == list(jawenv.PARAMETER_NAMES)
    prior = jawenv.cohort("anyone").prior
    np.testing.assert_allclose(found["prior_sd"], prior.sd)
    assert found["versions"]["numpy"]
    direction = np.array(found["least_known"]["direction"])
    assert found["least_known"]["sd"] == pytest.approx(np.sqrt(direction @ cov @ direction))
    assert found["least_known"]["sd"] >= np.sqrt(np.diag(cov)).max()
    assert f"least known: {found['least_known']['words']}, sd " in said
    assert found["enough"] == ("enough recorded: yes" in said) and "enough recorded: " in said
    assert found["enough"] == bool((np.sqrt(np.diagonal(found["log_cov"])) <= 0.05).all())
    assert all(name in said.split("at the edge of what was assumed: ")[1] for name in found["at_the_priors_edge"])


def test_in_python_it_is_the_same(tmp_path, capsys):
    path, file = without_labels(played("severe"), tmp_path / "bench.csv"), tmp_path / "answer.json"
    main(["identify", str(path), "--json", str(file)])
    said, answer = capsys.readouterr().out, jawenv.identify(path)
    assert str(answer) in said and answer.believed and answer.doubts == []
    found = json.loads(file.read_text(encoding="utf-8"))
    assert answer.mapping() == found and answer.log_mean.tolist() == found["log_mean"]
    assert answer.verdicts["masseter_left"].word in said and answer.log_sd.shape == (12,)


def test_a_file_that_states_its_patient_keeps_it(tmp_path):
    save_record(played("severe"), tmp_path / "severe.csv")
    record = load_record(tmp_path / "severe.csv")
    np.testing.assert_allclose(record.prior.mean, jawenv.cohort("severe").prior.mean)
    assert record.knowledge.exact
    again = load_record(tmp_path / "severe.csv", BENCH)
    assert again.knowledge.exact and np.array_equal(again.prior.mean, record.prior.mean)


def test_what_does_not_fit_begins_with_the_patient_who_does(tmp_path, capsys):
    path = without_labels(played("healthy", "slow_opening"), tmp_path / "healthy.csv")
    assert main(["identify", str(path), "--cohort", "severe", "--knowledge", "exact"]) == 3
    said = capsys.readouterr().out.split("NOT TO BE BELIEVED:\n")[1].splitlines()
    assert said[0].startswith("- the recording fits a person of whom nothing is known") and "not severe" in said[0]
    assert said[-1] == "Identify it again with --cohort anyone."


def test_a_jaw_at_the_teeth_teaches_nothing(tmp_path, capsys):
    """Sideways against the teeth the mouthpiece moves, and no muscle is stretched."""
    path, answer = without_labels(played("severe", "hold_still", 3.0), tmp_path / "still.csv"), tmp_path / "a.json"
    assert main(["identify", str(path), "--json", str(answer)]) == 3
    said = capsys.readouterr().out
    assert "stiff" not in said.split("F_o left : right")[1].split("NOT TO BE")[0]
    found = json.loads(answer.read_text(encoding="utf-8"))
    assert not found["believed"] and {one["word"] for one in found["verdicts"].values()} == {"no verdict"}
    assert found["verdicts"]["masseter_left"]["probability"] is None


def test_page_and_answer_are_two_files(tmp_path, capsys):
    path, answer = without_labels(played("severe"), tmp_path / "bench.csv"), tmp_path / "answer.html"
    assert main(["identify", str(path), "--json", str(answer), "--page", str(tmp_path / "." / "answer.html")]) == 2
    error = capsys.readouterr().err
    assert "--page and --json are both" in error and error.count("\n") == 1 and not answer.exists()


def test_a_model_of_known_anatomy_needs_no_label_either(tmp_path, capsys):
    world = {"record": True, "episode_s": 2.0, "model": "sagittal"}
    record = jawenv.play(load_agent("slow_opening"), patients=1, seed=7000, env_kwargs=world).records[0]
    path = without_labels(record, tmp_path / "bench.csv")
    main(["identify", str(path)])
    assert "patient: anyone" in (said := capsys.readouterr().out) and "anatomy: known exactly" in said
    assert main(["identify", str(path), "--knowledge", "bench"]) == 2
    assert "knowledge is not exact" in capsys.readouterr().err
