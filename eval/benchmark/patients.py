"""The patients' rows of a submission, read with the columns and values that this program writes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from eval.benchmark.tasks import TASKS
from eval.kept.tables import read_table
from eval.rows.times import COLUMNS
from jawenv.errors import InputError, shown

_COLUMNS = ("task", "agent", *COLUMNS)
_KINDS = {"task": "O", "agent": "O", "seed": "i", "violated": "b", "completed": "b"}  # of NumPy; others are floats
_LONGEST_S = max(task.episode_s for task in TASKS.values())
_REMEDY = "get the submission again"


def read_patients(path: Path, made_with: Mapping[str, Any]) -> pd.DataFrame:
    """Read ``benchmark.parquet``.

    Args:
        path: of the file.
        made_with: what the submission says that it was made with.

    Raises:
        InputError: it is missing or damaged, was made with something else, or has other columns or values than this
            program writes.
    """
    rows, about = read_table(path, _COLUMNS, _REMEDY)
    if about != made_with:
        raise InputError(f"{path}: was made with something else than the submission says; {_REMEDY}")
    if list(rows) != list(_COLUMNS):
        raise InputError(f"{path}: columns are {shown(list(rows))}; allowed: {', '.join(_COLUMNS)}")
    for column in _COLUMNS:
        kind = _KINDS.get(column, "f")
        if rows[column].dtype.kind != kind or (kind == "O" and not all(isinstance(each, str) for each in rows[column])):
            raise InputError(f"{path}: {column} holds other values than this program writes; {_REMEDY}")
    if not rows["score_s"].between(0.0, _LONGEST_S).all():
        raise InputError(f"{path}: score_s holds values outside of an episode; {_REMEDY}")
    return rows
