"""Parquet files, whose stated size is checked before they are read. Needs the package pyarrow."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from jawenv.errors import InputError
from jawenv.reading import LARGEST_DATA, open_file

_BYTES_OF_A_VALUE = 8


def read_parquet(path: Path, largest: int = LARGEST_DATA) -> pa.Table:
    """Read a table.

    Args:
        path: of the file.
        largest: size of the table in memory that is allowed, bytes.

    Raises:
        InputError: no such file, no regular one, or a table that is larger.
        pa.ArrowException: the file is damaged; also OSError and ValueError.
    """
    with open_file(path) as file:
        parquet = pq.ParquetFile(file)
        stated = parquet.metadata
        # A column of one value repeated takes no place in the file.
        groups = [stated.row_group(i) for i in range(stated.num_row_groups)]
        unpacked = sum(group.total_byte_size for group in groups)
        size = max(unpacked, stated.num_rows * stated.num_columns * _BYTES_OF_A_VALUE)
        if size > largest:
            raise InputError(f"{path}: its table takes {size:,} bytes; allowed: {largest:,} at most")
        return parquet.read()
