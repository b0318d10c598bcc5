"""Learning curves."""

from pathlib import Path

import numpy as np
import pytest

from training.cli import main
from training.run.config import TrainingConfig
from training.run.plot import _grouped, _mean_and_interval, _stacked

HEADER = "steps,return,worst_sd,known_s,discomfort_s"


@pytest.fixture
def runs(tmp_path: Path) -> list[Path]:
    folders = [tmp_path / name for name in ("sac-seed0", "sac-seed1", "ppo-seed0")]
    for k, folder in enumerate(folders):
        folder.mkdir()
        TrainingConfig().save(folder / "config.yaml")
        rows = [f"{100 * i},1,{0.1 - 0.01 * i + 0.02 * k},{0.2 + k},0.5" for i in range(3 + k)]
        (folder / "evaluations.csv").write_text("\n".join([HEADER, *rows]) + "\n")
    return folders


def test_picture_is_written(runs: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = tmp_path / "figures" / "curves.png"
    assert main(["plot", *map(str, runs), "--output", str(output)]) == 0
    assert output.read_bytes().startswith(b"\x89PNG") and str(output) in capsys.readouterr().out


def test_who_is_never_known_leaves_an_empty_panel(runs: list[Path], tmp_path: Path) -> None:
    table = runs[0] / "evaluations.csv"
    table.write_text("\n".join([HEADER, "0,1,0.4,inf,0.5", "100,1,0.3,inf,0.5"]) + "\n")
    assert main(["plot", str(runs[0]), "--output", str(tmp_path / "curves.png")]) == 0


def test_seeds_of_a_run_are_one_curve_as_far_as_all_have_come(runs: list[Path]) -> None:
    groups = _grouped([*runs, runs[0]])
    assert {name: len(tables) for name, tables in groups.items()} == {"sac": 2, "ppo": 1}
    steps, values = _stacked(groups["sac"], "worst_sd", 100.0)
    np.testing.assert_array_equal(steps, [0, 100, 200])
    np.testing.assert_allclose(values, [[10, 9, 8], [12, 11, 10]])


def test_interval_is_students() -> None:
    mean, half = _mean_and_interval(np.array([[1.0], [2.0], [3.0]]))
    assert mean[0] == 2.0 and half[0] == pytest.approx(4.30265 / np.sqrt(3), rel=1e-5)
    assert np.isnan(_mean_and_interval(np.array([[1.0]]))[1]).all()
