"""Searches and distillations that are killed or interrupted: given again, they end as a whole run does."""

import signal
import zipfile
from pathlib import Path

import pytest
from stopping import stopped, unfinished

from training.cli import main
from training.run.config import TrainingConfig
from training.run.folder import RunFolder
from training.search.distill import Labels, is_finished

CONFIG = """
algorithm: ppo
n_envs: 2
env: {kwargs: {control: targets, reward: worst, episode_s: 1.0}}
residual: {maneuver: opening_with_swings, scale: 2.0}
ppo: {n_steps: 5, batch_size: 10, network: {policy: [16], value: [16]}}
evaluation: {every_steps: 1000, patients: 2}
"""
OPTIMISE = ["--horizon-s", "4", "--patients", "2", "--population", "4", "--generations", "6"]
DISTILL = ["d.yaml", "--planner", "myopic", "--patients", "3", "--rounds", "2", "--output", "run"]


def both(tmp_path: Path) -> tuple[Path, Path]:
    folders = tmp_path / "stopped", tmp_path / "whole"
    for folder in folders:
        folder.mkdir()
        (folder / "d.yaml").write_text(CONFIG)
    return folders


def test_an_interrupted_search_goes_on_to_the_same_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    halves, whole = both(tmp_path)
    command = ["training", "optimise", "--output", "mine.yaml", *OPTIMISE]
    log = halves / "mine.search.txt"
    code, told = stopped(command, halves, lambda: log.exists() and log.read_text().count("\n") >= 3, signal.SIGINT)
    assert code == 130 and "the same command goes on from" in told and "Traceback" not in told
    assert log.read_text().count("\n") < 7 and not (halves / "mine.yaml").exists() and not unfinished(halves)
    for folder in (halves, whole):
        monkeypatch.chdir(folder)
        assert main(command[1:]) == 0
    for name in ("mine.yaml", "mine.search.txt"):
        assert (halves / name).read_bytes() == (whole / name).read_bytes()


def weights(path: Path) -> bytes:
    with zipfile.ZipFile(path) as archive:
        return archive.read("policy.pth")


def test_a_distillation_that_is_killed_after_its_labels_goes_on_to_the_same_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the labels of a round are there for, its evaluation and the best model, is made up for."""
    halves, whole = both(tmp_path)
    labels = halves / "run" / "labels" / "round_00.npz"
    code, _ = stopped(["training", "distill", *DISTILL], halves, labels.exists)
    assert code == -signal.SIGKILL and not (halves / "run" / "final_model.zip").exists()
    for folder in (halves, whole):
        monkeypatch.chdir(folder)
        assert main(["distill", *DISTILL]) == 0
    one, other = RunFolder(halves / "run"), RunFolder(whole / "run")
    assert one.evaluations.read_bytes() == other.evaluations.read_bytes()
    assert weights(one.best_model) == weights(other.best_model)
    assert weights(one.final_model) == weights(other.final_model)
    assert {path.name for path in one.checkpoints.iterdir()} == {path.name for path in other.checkpoints.iterdir()}
    assert not unfinished(halves)
    assert is_finished(one, 2)
    Labels.load(one.labels / "round_00.npz").save(one.labels / "round_02.npz")
    assert not is_finished(one, 3), "the final model has not learnt from the last labels"


def test_a_run_folder_is_made_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run = RunFolder(tmp_path / "run")
    run.create(TrainingConfig(seed=1), "{}", 0)
    with monkeypatch.context() as patch:
        patch.setattr(TrainingConfig, "save", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            run.create(TrainingConfig(seed=2), "{}", 0)
    assert run.open().seed == 1 and run.repeat_file.is_file()
    run.create(TrainingConfig(seed=2), "{}", 0)
    assert run.open().seed == 2 and [path.name for path in tmp_path.iterdir()] == ["run"]
