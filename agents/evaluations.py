"""The evaluations of a training run, ``evaluations.csv``, read without PyTorch."""

from __future__ import annotations

import csv
from pathlib import Path

from jawenv.base.errors import InputError
from jawenv.base.reading import read_text

FILE = "evaluations.csv"
Table = list[dict[str, float]]
"""Evaluations of one run, a row each, by the names of the columns."""


def read_evaluations(run: Path) -> Table:
    """The evaluations so far of the run in a folder; none if there is no such file."""
    path = run / FILE
    if not path.exists():
        return []
    try:
        lines = read_text(path).splitlines()
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(lines)]
        if any(not {"steps", "return"} <= set(row) for row in rows):
            raise ValueError("a column 'steps' or 'return' is missing")
    except InputError:
        raise
    except (ValueError, TypeError, AttributeError, csv.Error) as error:
        raise InputError(f"{path} is damaged: {' '.join(str(error).split())[:120]}") from error
    return rows
