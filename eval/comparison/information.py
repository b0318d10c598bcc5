"""Expected information gain of maneuvers and agents, in the units of Bayesian experimental design."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
import pandas as pd

from eval.figures import words
from eval.figures.tables import Table
from eval.kept.cells import Cell
from eval.kept.entries import Settings, load_entries, load_entry
from eval.rows.gains import Gains
from jawenv.base.errors import InputError

PATIENTS_IN_A_PART = 5
HEAD = (
    "design",
    "patients",
    "lower, nats",
    "upper, nats",
    "of the belief, nats",
    "claimed, nats",
    "effective contrasts",
    "ended early",
)
NOTE = (
    "Expected information gain about all parameters, mean ± standard error over the patients. Lower and upper: "
    "contrastive, with contrasts from the filter's belief (ACE and VNMC; with contrasts from the prior they would be "
    "sPCE and sNMC). Of the belief: Barber and Agakov's lower bound with the filter's belief as the posterior. "
    "Claimed: half the logarithm of the determinant of prior over posterior covariance, as the filter says it. "
    "Effective contrasts: the mean number; where it is small the upper bound is far above the gain."
)
_BOUNDS = ("lower", "upper", "posterior", "claimed")


def cells_of(specs: Sequence[str], settings: Settings, contrasts: int, *, trust: bool = False) -> list[Cell]:
    """A cell for every entry.

    Args:
        specs: maneuvers, files, runs, exported policies or agents of one's own.
        settings: patients and environment; the filter must know all but the patient.
        contrasts: of each record; 0 leaves the contrastive bounds out.
        trust: whether stable-baselines3 checkpoints may be unpickled.
    """
    if not specs:
        raise InputError("nothing to play: name a maneuver, a file, a training run or a policy")
    if contrasts < 0:
        raise InputError(f"contrasts is {contrasts}; allowed: 0 or more")
    return [
        Cell(
            {"entry": entry.label},
            partial(load_entry, entry.spec, settings.world, trust=trust),
            settings.seeds,
            Gains(contrasts),
            PATIENTS_IN_A_PART,
        )
        for entry in load_entries(specs, settings.world, trust=trust)
    ]


def summarise(rows: pd.DataFrame) -> pd.DataFrame:
    """One row per entry; ``_error`` is the standard error of the mean of that name.

    Args:
        rows: of `eval.kept.cells.play_cells`.
    """
    return pd.DataFrame([_figures(str(entry), of_entry) for entry, of_entry in rows.groupby("entry", sort=False)])


def _figures(entry: str, rows: pd.DataFrame) -> dict[str, object]:
    figures: dict[str, object] = {"entry": entry, "patients": len(rows)}
    for name in _BOUNDS:
        values = rows[name].to_numpy(dtype=np.float64)
        figures[name] = values.mean()
        figures[f"{name}_error"] = values.std(ddof=1) / np.sqrt(len(values)) if len(values) > 1 else np.nan
    return figures | {"effective": rows["effective"].mean(), "ended": int(rows["ended"].sum())}


def table(summary: pd.DataFrame) -> Table:
    """The table of `summarise`."""
    rows = [_cells(row) for _, row in summary.iterrows()]
    return Table(HEAD, rows, note=NOTE, title="Expected information gain")


def _cells(row: pd.Series) -> list[str]:
    bounds = [_with_error(row[name], row[f"{name}_error"]) for name in _BOUNDS]
    contrasts = words.number(row["effective"] if row["effective"] > 0.0 else float("nan"))
    return [words.label(row["entry"]), str(row["patients"]), *bounds, contrasts, str(row["ended"])]


def _with_error(value: float, error: float) -> str:
    """A cell such as `8.27 ± 0.13`."""
    return words.number(value, 2) + ("" if pd.isna(error) else f" ± {words.number(error, 2)}")
