"""The table of a run's evaluations, ``evaluations.csv``: written a row at a time, and read without PyTorch."""

from __future__ import annotations

import csv

from jawenv.errors import InputError
from jawenv.reading import read_text
from training.run.folder import RunFolder


def add_row(run: RunFolder, steps: int, row: dict[str, float]) -> None:
    """Add a row; the table of a run that goes on keeps its columns."""
    new = not run.evaluations.exists()
    names = ["steps", *row] if new else read_text(run.evaluations).partition("\n")[0].strip().split(",")
    with run.evaluations.open("a", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, names, extrasaction="ignore")
        if new:
            writer.writeheader()
        writer.writerow({"steps": steps} | {name: f"{value:.6g}" for name, value in row.items()})


def read_evaluations(run: RunFolder) -> list[dict[str, float]]:
    """The rows of ``evaluations.csv`` so far.

    Raises:
        InputError: the table is damaged.
    """
    if not run.evaluations.exists():
        return []
    try:
        lines = read_text(run.evaluations).splitlines()
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(lines)]
        if any(not {"steps", "return"} <= set(row) for row in rows):
            raise ValueError("a column 'steps' or 'return' is missing")
    except InputError:
        raise
    except (ValueError, TypeError, AttributeError, csv.Error) as error:
        raise InputError(f"{run.evaluations} is damaged: {' '.join(str(error).split())[:120]}") from error
    return rows
