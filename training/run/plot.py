"""Learning curves of finished or running trainings, averaged over seeds."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from agents.evaluations import CURVES, Table, read_evaluations
from jawenv.base.errors import InputError
from jawenv.base.extras import needs
from jawenv.base.files import atomic_write
from jawenv.base.locks import alone
from training.run.folder import RunFolder

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CONFIDENCE = 0.95
_HEADROOM = 1.12  # of the highest value: no curve lies on the upper axis
_LEGEND_COLUMNS = 3
_SEED = re.compile(r"-seed\d+$")


def draw(runs: Sequence[Path], output: Path) -> Path:
    """Draw the curves of some runs; runs that differ in ``-seedK`` alone become one, with its mean and interval.

    Args:
        runs: run folders.
        output: the picture, a .png.

    Returns:
        Where it lies.
    """
    if output.suffix.lower() != ".png":
        raise InputError(f"output is {output}; allowed: a file that ends in .png")
    groups = _grouped(runs)
    with needs("python -m training plot", "matplotlib", group="train"):
        picture = figure(groups)
    with alone(output), atomic_write(output) as unfinished:
        picture.savefig(unfinished, format="png", dpi=150)
    return output


def figure(groups: dict[str, list[Table]]) -> Figure:
    """The curves of groups of runs, with the legend above the panels.

    Args:
        groups: tables of evaluations, one for each seed, by their label in the legend.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import EngFormatter, MaxNLocator

    lines = -(-len(groups) // _LEGEND_COLUMNS)
    picture = Figure(figsize=(12.0, 3.6 + 0.22 * lines), layout="constrained")
    panels: Any = picture.subplots(1, len(CURVES))
    for axes, (column, label, factor) in zip(panels, CURVES, strict=True):
        for name, tables in groups.items():
            _curve(axes, name, *_stacked(tables, column, factor))
        highest = axes.dataLim.ymax
        end = _HEADROOM * highest if np.isfinite(highest) and highest > 0.0 else 1.0
        axes.set(xlabel="environment steps", ylabel=label, ylim=(0.0, end))
        axes.xaxis.set_major_locator(MaxNLocator(5))
        axes.xaxis.set_major_formatter(EngFormatter(sep=""))
        axes.grid(alpha=0.3)
    curves, names = panels[0].get_legend_handles_labels()
    picture.legend(curves, names, loc="outside upper center", ncols=_LEGEND_COLUMNS, frameon=False)
    return picture


def _mean_and_interval(values: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean (T,) of curves (S, T) over seeds and the half width (T,) of Student's 95 % interval of it; NaN for S = 1."""
    from scipy.stats import t

    seeds = len(values)
    mean: NDArray[np.float64] = values.mean(axis=0)
    if seeds < 2:
        return mean, np.full_like(mean, np.nan)
    error = values.std(axis=0, ddof=1) / np.sqrt(seeds)
    return mean, error * float(t.ppf(0.5 + 0.5 * CONFIDENCE, seeds - 1))


def _grouped(runs: Sequence[Path]) -> dict[str, list[Table]]:
    """Tables of evaluations by the runs' names without their seeds."""
    groups: dict[str, list[Table]] = {}
    for path in dict.fromkeys(run.resolve() for run in runs):
        run = RunFolder(path)
        if not run.exists():
            raise InputError(f"{path} holds no run: there is no {run.config_file.name} in it")
        table = read_evaluations(path)
        if not table:
            raise InputError(f"{path} holds no evaluations yet")
        for column, _, _ in CURVES:
            if column not in table[0]:
                raise InputError(f"{run.evaluations} has no column {column!r}")
        groups.setdefault(_SEED.sub("", path.name), []).append(table)
    return groups


def _stacked(tables: list[Table], column: str, factor: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Steps (T,) and values (S, T) at the evaluations of the first seed, as far as all seeds have come.

    Between two evaluations of another seed its value is interpolated.
    """
    end = min(table[-1]["steps"] for table in tables)
    steps = np.array([row["steps"] for row in tables[0] if row["steps"] <= end])
    curves = [
        np.interp(steps, [row["steps"] for row in table], [_finite(factor * row[column]) for row in table])
        for table in tables
    ]
    return steps, np.stack(curves)


def _finite(value: float) -> float:
    """A value, or NaN where it is infinite, of which nothing is drawn."""
    return value if np.isfinite(value) else np.nan


def _curve(axes: Axes, name: str, steps: NDArray[np.float64], values: NDArray[np.float64]) -> None:
    mean, half_width = _mean_and_interval(values)
    label = name if len(values) == 1 else f"{name} ({len(values)} seeds)"
    (line,) = axes.plot(steps, mean, label=label)
    if len(values) > 1:
        axes.fill_between(steps, mean - half_width, mean + half_width, color=line.get_color(), alpha=0.2, linewidth=0.0)
