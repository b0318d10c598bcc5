"""``python -m training export``: the folder holds the run's best policy, and its card and README say what it is."""

import sys
from datetime import UTC, datetime
from pathlib import Path

import pytest
import yaml
from markdown import markdown

from jawenv.playing.policies.card import SHIPPED, ModelCard, Result, policy_names, read_card
from tests.plain_policies import write_corrector
from training.cli import main
from training.run.config import TrainingConfig
from training.run.export import README, metadata, readme


@pytest.fixture
def run(tmp_path: Path) -> Path:
    folder = write_corrector(tmp_path / "run", "slow_opening")
    TrainingConfig().save(folder / "config.yaml")
    return folder


def export(run: Path, output: Path, *more: object) -> int:
    return main(["export", str(run), "--output", str(output), *map(str, more)])


def refused(capsys: pytest.CaptureFixture[str], run: Path, output: Path, *more: object) -> str:
    capsys.readouterr()
    assert export(run, output, *more) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ") and error.count("\n") == 1
    return error


ROW = {
    "cohort": "trismus",
    "patients": 64,
    "seeds": (500, 563),
    "metric": "nats",
    "low": 44.4,
    "high": 46.5,
    "mean": 45.5,
}


def test_it_is_the_runs_policy_with_what_it_reached(run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["training", "export", "a run"])
    monkeypatch.setattr("eval.comparison.card_results.results_of_run", lambda folder, path: (Result(**ROW),))
    assert export(run, tmp_path / "shared", "--licence", "CC-BY-4.0", "--results", tmp_path) == 0
    kept, card = read_card(run), read_card(tmp_path / "shared")
    assert (tmp_path / "shared" / "policy.safetensors").read_bytes() == (run / "policy.safetensors").read_bytes()
    (result,) = card.results
    assert (result.mean, result.low, result.seeds, result.level) == (45.5, 44.4, (500, 563), 0.95)
    assert card.licence == "CC-BY-4.0" and abs((card.date - datetime.now(UTC).date()).days) <= 1
    assert card.commands == (*kept.commands, "python -m training export 'a run'")
    said_anew = {"results", "licence", "date", "commands"}
    assert card.model_dump(exclude=said_anew) == kept.model_dump(exclude=said_anew)


def test_damaged_results_and_a_run_without_a_policy_are_refused(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "nowhere" in refused(capsys, run, tmp_path / "none", "--results", tmp_path / "nowhere")
    (run / "card.json").unlink()
    assert "card.json" in refused(capsys, run, tmp_path / "none")
    (run / "config.yaml").unlink()
    assert "holds no run" in refused(capsys, run, tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_nothing_is_replaced_unasked(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = tmp_path / "shared"
    assert export(run, output) == 0
    files = {path.name for path in output.iterdir()}
    assert "--overwrite" in refused(capsys, run, output)
    assert export(run, output, "--overwrite", "--licence", "CC0-1.0") == 0
    assert read_card(output).licence == "CC0-1.0"
    refused(capsys, run, run, "--overwrite")
    (tmp_path / "file").write_text("text")
    refused(capsys, run, tmp_path / "file")
    (output / "card.json").unlink()  # as an export leaves it that was stopped
    (output / ".card.json.0123.unfinished").write_text("{")
    assert export(run, output) == 0
    assert {path.name for path in output.iterdir()} == files == {"card.json", "policy.safetensors", "README.md"}


def header_of(text: str) -> dict:
    start, header, _ = text.split("---\n", 2)
    assert start == ""
    return yaml.safe_load(header)


@pytest.mark.parametrize("name", policy_names())
def test_the_readme_of_a_policy_that_comes_along_is_of_its_card(name: str) -> None:
    text = (SHIPPED / name / README).read_text(encoding="utf-8")
    card = read_card(SHIPPED / name)
    assert text == readme(name, card)
    header = header_of(text)
    assert header["license"] == "mit" and {"gymnasium", card.algorithm} <= set(header["tags"])
    assert text.count("simulated patients |") == bool(card.results)


def card_with(**changed: object) -> ModelCard:
    fields = read_card(SHIPPED / "ppo_trismus").model_dump(mode="json")
    return ModelCard.model_validate(fields | changed)


@pytest.mark.parametrize(
    ("licence", "expected"),
    [("CC-BY-4.0", {"license": "cc-by-4.0"}), ("Our own, 2030", {"license": "other", "license_name": "our-own-2030"})],
)
def test_a_licence_is_named_as_the_hub_names_it(licence: str, expected: dict) -> None:
    assert expected.items() <= metadata(card_with(licence=licence, results=[])).items()


def test_what_a_card_says_cannot_break_the_page() -> None:
    told, flat = "a | b\n---\n# no: [yaml", "a | b --- # no: [yaml"
    result = read_card(SHIPPED / "ppo_trismus").results[0].model_dump(mode="json") | {"metric": told}
    text = readme('größe "y', card_with(results=[result], licence=told, algorithm=told))
    header = header_of(text)
    assert flat in header["tags"]
    assert "<h1>no" not in markdown(text.split("---\n", 2)[2])


def test_evaluations_come_along(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output, table = tmp_path / "shared", "steps,return\n0,1.5\n64,2.5\n"
    (run / "evaluations.csv").write_text(table)
    assert export(run, output) == 0
    assert (output / "evaluations.csv").read_text() == table
    (run / "evaluations.csv").write_text("steps\nmany\n")
    assert "evaluations.csv is damaged" in refused(capsys, run, output, "--overwrite")
    assert (output / "evaluations.csv").read_text() == table
    (run / "evaluations.csv").unlink()
    assert export(run, output, "--overwrite") == 0
    assert not (output / "evaluations.csv").exists()
