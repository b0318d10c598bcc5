"""Tables that are kept: a flipped bit is noticed in one line, or changes nothing."""

from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from eval.kept.tables import read_table, write_table
from jawenv.errors import InputError

FLIPS = 400
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


def test_a_flipped_bit_is_noticed_or_changes_nothing(tmp_path: Path) -> None:
    rows, path = some_rows(), tmp_path / "a.parquet"
    write_table(rows, path, ABOUT)
    content = path.read_bytes()
    noticed = 0
    for bit in np.random.default_rng(1).integers(8 * len(content), size=FLIPS):
        damaged = bytearray(content)
        damaged[bit // 8] ^= 1 << (bit % 8)
        path.write_bytes(damaged)
        try:
            frame, about = read_table(path)
        except InputError as error:
            assert "\n" not in str(error) and str(path) in str(error)
            noticed += 1
        else:
            assert about == ABOUT, bit
            pd.testing.assert_frame_equal(frame, rows, obj=f"bit {bit}")
    assert noticed > 0.7 * FLIPS


def test_a_renamed_column_is_noticed(tmp_path: Path) -> None:
    """No page has changed, but the head."""
    write_table(some_rows(), tmp_path / "a.parquet", ABOUT)
    table = pq.read_table(tmp_path / "a.parquet")
    renamed = table.rename_columns({"worst_sd": "worst_se"}).replace_schema_metadata(table.schema.metadata)
    pq.write_table(renamed, tmp_path / "a.parquet")
    with pytest.raises(
        InputError, match=r"a\.parquet is damaged \(what the file says of its table does not fit its dig"
    ):
        read_table(tmp_path / "a.parquet")
