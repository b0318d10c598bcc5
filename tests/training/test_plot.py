"""Learning curves."""

import builtins
import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from training.cli import main
from training.run.config import TrainingConfig
from training.run.plot import _grouped, _stacked, figure, mean_and_interval

HEADER = "steps,return,worst_sd,worst_sd_10s,discomfort_s"


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


def test_nothing_lies_on_an_axis_under_the_legend_or_on_another_label() -> None:
    """Curves that hardly change are as high as all else: they stand below the upper axis, and the legend above it."""
    names = ("ppo", "recurrent_ppo_residual_on_refined", "sac", "tqc")
    table = [{"steps": 9600.0 * i, "worst_sd": 0.0124, "worst_sd_10s": 0.022, "discomfort_s": 0.0} for i in range(13)]
    picture = figure({name: [table] for name in names})
    canvas: Any = FigureCanvasAgg(picture)
    canvas.draw()
    (legend,) = picture.legends
    assert [text.get_text() for text in legend.get_texts()] == list(names)
    for axes in picture.axes:
        assert not axes.get_legend() and not legend.get_window_extent().overlaps(axes.get_window_extent())
        assert axes.dataLim.ymax < 0.95 * axes.get_ylim()[1]
        labels = [label.get_window_extent() for label in axes.get_xticklabels() if label.get_text()]
        assert all(left.x1 < right.x0 for left, right in itertools.pairwise(labels))


def test_seeds_of_a_run_are_one_curve_as_far_as_all_have_come(runs: list[Path]) -> None:
    groups = _grouped([*runs, runs[0]])
    assert {name: len(tables) for name, tables in groups.items()} == {"sac": 2, "ppo": 1}
    steps, values = _stacked(groups["sac"], "worst_sd", 100.0)
    np.testing.assert_array_equal(steps, [0, 100, 200])
    np.testing.assert_allclose(values, [[10, 9, 8], [12, 11, 10]])


def test_interval_is_students() -> None:
    mean, half = mean_and_interval(np.array([[1.0], [2.0], [3.0]]))
    assert mean[0] == 2.0 and half[0] == pytest.approx(4.30265 / np.sqrt(3), rel=1e-5)
    assert np.isnan(mean_and_interval(np.array([[1.0]]))[1]).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda run: (run / "evaluations.csv").unlink(), "holds no evaluations yet"),
        (lambda run: (run / "config.yaml").unlink(), "holds no run"),
        (lambda run: (run / "evaluations.csv").write_text("steps,return\n0,x\n"), "evaluations.csv is damaged"),
        (lambda run: (run / "evaluations.csv").write_text("steps,return\n0,1\n"), "has no column 'worst_sd_10s'"),
    ],
)
def test_unusable_runs_are_named(
    runs: list[Path], capsys: pytest.CaptureFixture[str], change: Any, message: str
) -> None:
    change(runs[1])
    assert main(["plot", *map(str, runs)]) == 2
    error = capsys.readouterr().err
    assert "sac-seed1" in error and message in error and error.count("\n") == 1


def test_other_pictures_are_refused(runs: list[Path], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plot", str(runs[0]), "--output", "curves.pdf"]) == 2
    assert capsys.readouterr().err == "error: output curves.pdf: must end in .png\n"


def test_missing_matplotlib_is_one_line(
    runs: list[Path], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    real = builtins.__import__

    def without(name: str, *arguments: Any, **keywords: Any) -> Any:
        if name.startswith("matplotlib"):
            raise ModuleNotFoundError(f"No module named '{name}'", name=name)
        return real(name, *arguments, **keywords)

    monkeypatch.setattr(builtins, "__import__", without)
    assert main(["plot", str(runs[0])]) == 2
    error = capsys.readouterr().err
    assert "needs matplotlib" in error and error.count("\n") == 1
