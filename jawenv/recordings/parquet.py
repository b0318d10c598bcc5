"""Parquet files whose stated size and checksums are checked as they are read. Needs the package pyarrow.

Pages of values have the checksums of Parquet. What the footer says, which has none there, has a digest among its words:
of names and types of the columns, the number of rows, and all other words.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from jawenv.base.errors import InputError
from jawenv.base.reading import LARGEST_DATA, open_file

_BYTES_OF_A_VALUE = 8
_DIGEST = b"jawenv.head_sha256"


def write_parquet(table: pa.Table, target: Any) -> None:
    """Write a table with checksums.

    Args:
        table: with words about it in its schema's metadata.
        target: a path, or a file open for writing.
    """
    words = {**(table.schema.metadata or {}), _DIGEST: _head(table)}
    pq.write_table(table.replace_schema_metadata(words), target, compression="zstd", write_page_checksum=True)


def read_parquet(path: Path, largest: int = LARGEST_DATA) -> pa.Table:
    """Read a table.

    Args:
        path: of the file.
        largest: size of the table in memory that is allowed, bytes.
    """
    with open_file(path) as file:
        parquet = pq.ParquetFile(file, page_checksum_verification=True)
        stated = parquet.metadata
        # A column of one value repeated takes no place in the file.
        groups = [stated.row_group(i) for i in range(stated.num_row_groups)]
        unpacked = sum(group.total_byte_size for group in groups)
        size = max(unpacked, stated.num_rows * stated.num_columns * _BYTES_OF_A_VALUE)
        if size > largest:
            raise InputError(f"{path}: its table takes {size:,} bytes; allowed: {largest:,} at most")
        table = parquet.read()
    digest = (table.schema.metadata or {}).get(_DIGEST)
    if digest is not None and digest != _head(table):
        raise ValueError("what the file says of its table does not fit its digest")
    return table


def _head(table: pa.Table) -> bytes:
    words = {key: value for key, value in (table.schema.metadata or {}).items() if key != _DIGEST}
    # Parquet calls the values of a list by another name than Arrow.
    columns = [(column.name, str(column.type).replace("<element: ", "<item: ")) for column in table.schema]
    content = [table.num_rows, columns, sorted(words.items())]
    return hashlib.sha256(repr(content).encode()).hexdigest().encode()
