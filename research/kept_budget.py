"""Entries with and without a kept budget of discomfort, in every cohort: docs/tables/kept_budget.md.

    python -m research.kept_budget --patients 200 > docs/tables/kept_budget.md

Ten seconds in targets control, patients of reports. The log of the worst error bar, and of the root mean square error,
stands beside the movement `universal` with the same budget on the same patients; *loss* beside the entry without one.
Ctrl-C keeps what is finished.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
from rich.console import Console

from eval.figures import statistics, words
from eval.kept.cells import Cell, play_cells
from eval.kept.entries import load_entry
from eval.kept.parts import Run
from eval.rows.outcomes import Outcomes
from jawenv.anatomy import COHORTS
from jawenv.base.seeds import REPORTS
from jawenv.envs.configuration import Configuration
from jawenv.playing.policies.named import agent_names
from research._beliefs import head, row

_SECONDS, _BUDGET_S, _TOGETHER = 10.0, 1.0 / 30.0, 50
_BESIDE, _FREE, _KEPT = "universal", "free", "kept"
_HEADINGS = (
    "entry",
    "log worst beside",
    "true error",
    "loss",
    "above, %, free → kept",
    "s to 5 %",
    "nine in ten",
    "s to verdicts",
    "NEES/12",
)


def cells_of(entries: Sequence[str], cohorts: Sequence[str], env: str, patients: int) -> list[Cell]:
    """Every entry in every cohort, with and without the budget."""
    seeds = range(REPORTS[1].start, REPORTS[1].start + patients)
    cells = []
    for cohort, (name, budget_s), entry in product(cohorts, ((_FREE, None), (_KEPT, _BUDGET_S)), entries):
        arguments = {"env": env, "cohort": cohort, "control": "targets", "episode_s": _SECONDS}
        world = Configuration.from_mapping(arguments | {"comfort_budget_s": budget_s})
        levels, load = {"cohort": cohort, "budget": name, "entry": entry}, partial(load_entry, entry, world)
        cells.append(Cell(levels, load, seeds, Outcomes(bound=False, over_time=False), _TOGETHER))
    return cells


def _of_entry(rows: pd.DataFrame, entry: str) -> list[str]:
    """Cells of an entry, of the rows of one cohort."""
    beside, free, kept = (
        rows[(rows["budget"] == budget) & (rows["entry"] == name)].reset_index(drop=True)
        for budget, name in ((_KEPT, _BESIDE), (_FREE, entry), (_KEPT, entry))
    )
    above = [f"{100.0 * np.mean(each['discomfort_s'] > _BUDGET_S):.0f}" for each in (free, kept)]
    sure, verdicts = (np.minimum(kept[name], _SECONDS) for name in ("time_to_0.05_s", "verdicts_s"))
    nees = kept["nees"] / kept.filter(like="truth/").iloc[0].notna().sum()
    return [
        f"`{entry}`",
        words.with_interval(statistics.mean(np.asarray(np.log(kept["worst_sd"] / beside["worst_sd"]))), 3),
        words.with_interval(statistics.mean(np.asarray(np.log(kept["rmse"] / beside["rmse"]))), 2),
        f"{np.log(kept['worst_sd'] / free['worst_sd']).mean():+.3f}",
        " → ".join(above),
        f"{sure.mean():.2f}",
        f"{np.quantile(sure, 0.9):.1f}",
        words.with_interval(statistics.mean(np.asarray(verdicts)), 2),
        f"{nees.mean():.2f}",
    ]


def main(argv: Sequence[str] | None = None) -> None:
    """Print a table for each cohort."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("entries", nargs="*", metavar="ENTRY", help="all of the project by default")
    parser.add_argument("--patients", type=int, default=200, metavar="N")
    parser.add_argument("--cohorts", nargs="+", default=list(COHORTS), metavar="NAME")
    parser.add_argument("--env", default="jawenv/Jaw-v3", metavar="ID")
    parser.add_argument("--output", type=Path, default=Path("runs/kept_budget"), metavar="FOLDER")
    asked = parser.parse_args(argv)
    entries = asked.entries or [name for name in agent_names() if not name.endswith(("_force", "_asked"))]
    cells = cells_of(list(dict.fromkeys([*entries, _BESIDE])), asked.cohorts, asked.env, asked.patients)
    rows = play_cells(cells, asked.output, Run(console=Console(stderr=True)))
    for cohort, of_cohort in rows.groupby("cohort", sort=False):
        print(f"\n**{cohort}**, {asked.patients} patients\n")
        head(*_HEADINGS)
        for entry in entries:
            row(*_of_entry(of_cohort, entry))


if __name__ == "__main__":
    main()
