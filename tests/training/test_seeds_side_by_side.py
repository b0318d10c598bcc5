"""Several seeds of a training, one by one, side by side, and through Ray: the same bits each time."""

import filecmp
from pathlib import Path

import pytest
import torch
from stable_baselines3 import PPO
from test_command import evaluations, train

from training.run.folder import RunFolder
from training.run.seeds import _parsed


@pytest.mark.parametrize(
    ("text", "seeds"), [("3", [3]), ("0-4", [0, 1, 2, 3, 4]), ("0,1,2", [0, 1, 2]), ("7, 1-2,2", [7, 1, 2])]
)
def test_seeds_are_read(text: str, seeds: list[int]) -> None:
    assert _parsed(text) == seeds


def test_finished_seeds_are_skipped_unfinished_ones_go_on_and_settings_are_not_mixed(
    tiny_config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = [tiny_config, "--output", tmp_path / "study", "--seeds"]
    assert train(*command, "1", "--steps", 512) == 0
    assert train(*command, "2", "--steps", 256) == 0
    capsys.readouterr()
    assert train(*command, "1-3", "--steps", 512) == 0
    output = capsys.readouterr().out
    assert output.count("nothing to do") == 1 and "seed 3, 3 of 3" in output
    for seed, steps in ((1, [0, 512]), (2, [0, 256, 512]), (3, [0, 512])):
        run = RunFolder(tmp_path / f"study-seed{seed}")
        assert run.open().seed == seed and [row["steps"] for row in evaluations(run.path)] == steps
    tiny_config.write_text(tiny_config.read_text().replace("n_steps: 32", "n_steps: 16"))
    assert train(*command, "0-1") == 2
    assert "(arguments)" in capsys.readouterr().err
    assert not (tmp_path / "study-seed0").exists(), "nothing is begun if one folder has other settings"


def trained(config: Path, stem: Path, *more: object) -> Path:
    assert train(config, "--output", stem, "--seeds", "0-2", *more) == 0
    return stem


def assert_same(one: Path, other: Path) -> None:
    """The seeds' runs of two stems are equal to the bit."""
    for seed in range(3):
        run, again = (stem.with_name(f"{stem.name}-seed{seed}") for stem in (one, other))
        assert filecmp.cmp(run / "evaluations.csv", again / "evaluations.csv", shallow=False)
        first, second = (PPO.load(path / "best_model.zip", device="cpu").policy.state_dict() for path in (run, again))
        assert all(torch.equal(first[key], second[key]) for key in first)


def test_seeds_side_by_side_equal_those_one_by_one_and_go_on(
    tiny_config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    alone = trained(tiny_config, tmp_path / "alone")
    assert train(tiny_config, "--output", tmp_path / "beside-seed1", "--seed", 1, "--steps", 1024) == 0
    capsys.readouterr()
    beside = trained(tiny_config, tmp_path / "beside", "--workers", 2)
    assert_same(alone, beside)
    said = capsys.readouterr().out
    assert "seed 2: " in said and "beside-seed2.log" in said
    logs = [(tmp_path / f"beside-seed{seed}.log").read_text() for seed in range(3)]
    assert ["nothing to do" in log for log in logs] == [False, True, False]
    assert "1,024 steps in" in logs[0]


def test_seeds_by_ray_equal_those_of_one_machine(
    tiny_config: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ray = pytest.importorskip("ray", reason="ray is not installed: .ci/setup cluster")
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))  # Ray's processes import point_env too
    try:
        by_ray = trained(tiny_config, tmp_path / "by_ray", "--backend", "ray", "--workers", 2)
    finally:
        ray.shutdown()
    assert_same(trained(tiny_config, tmp_path / "alone"), by_ray)


def test_a_refusal_of_one_seed_is_one_line(
    tiny_config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tiny_config.write_text(tiny_config.read_text().replace("Point-v0", "None-v0"))
    assert train(tiny_config, "--output", tmp_path / "run", "--seeds", "0-1", "--workers", 2) == 2
    assert capsys.readouterr().err.count("\n") == 1
