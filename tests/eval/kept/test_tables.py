"""Tables that are kept: a flipped bit is noticed in one line, or changes nothing."""

from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from eval.kept.tables import read_table, write_table
from jawenv.base.errors import InputError

ABOUT = {"command": "eval compare", "seeds": [500, 501]}


def some_rows() -> pd.DataFrame:
    rng = np.random.default_rng(0)
    entry = np.repeat(["hold_still", "refined"], 100)
    sd = np.where(rng.random(200) < 0.1, np.nan, rng.random(200))
    return pd.DataFrame({"entry": entry, "seed": np.arange(200), "worst_sd": sd, "ranked": rng.random(200) < 0.5})


def test_a_table_comes_back(tmp_path: Path) -> None:
    write_table(some_rows(), tmp_path / "a.parquet", ABOUT)
    frame, about = read_table(tmp_path / "a.parquet")
    pd.testing.assert_frame_equal(frame, some_rows())
    assert about == ABOUT


def test_a_renamed_column_is_noticed(tmp_path: Path) -> None:
    """No page has changed, but the head."""
    write_table(some_rows(), tmp_path / "a.parquet", ABOUT)
    table = pq.read_table(tmp_path / "a.parquet")
    renamed = table.rename_columns({"worst_sd": "worst_se"}).replace_schema_metadata(table.schema.metadata)
    pq.write_table(renamed, tmp_path / "a.parquet")
    with pytest.raises(InputError):
        read_table(tmp_path / "a.parquet")
