"""Tables as Parquet files, whole or not at all, with metadata on their making."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa

from jawenv.base import versions
from jawenv.base.errors import InputError
from jawenv.base.files import atomic_write
from jawenv.recordings.parquet import read_parquet, write_parquet

_KEY = b"jawenv.eval"


def made_with(command: str, **more: Any) -> dict[str, Any]:
    """Metadata of results: the command, further keywords, `jawenv.base.versions.made_with`, and the time now."""
    now = time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime())
    return versions.made_with(command=command, **more, finished=now)


def write_table(frame: pd.DataFrame, path: Path, metadata: dict[str, Any]) -> None:
    """Write a table with its metadata."""
    table = pa.Table.from_pandas(frame, preserve_index=False)
    schema_metadata = {**(table.schema.metadata or {}), _KEY: json.dumps(metadata, sort_keys=True).encode()}
    with atomic_write(path) as unfinished:
        write_parquet(table.replace_schema_metadata(schema_metadata), unfinished)


def read_table(
    path: Path, columns: Sequence[str] = (), remedy: str = "delete it, or use --fresh"
) -> tuple[pd.DataFrame, dict[str, Any]]:
    """Read a file of ``write_table``.

    Args:
        path: of the file.
        columns: those that it must have.
        remedy: advice for a damaged file.
    """
    try:
        table = read_parquet(path)
        metadata = json.loads((table.schema.metadata or {}).get(_KEY, b"null"))
        frame = table.to_pandas()
    except (OSError, pa.ArrowException, ValueError, TypeError, KeyError) as error:
        if isinstance(error, InputError):
            raise
        reason = " ".join(str(error).split())[:120]
        raise InputError(f"{path} is damaged ({reason}); {remedy}") from None
    missing = [column for column in columns if column not in frame]
    if metadata is None or missing:
        lacks = f"column {missing[0]!r}" if missing else "what it was made with"
        raise InputError(f"{path} is no table of this program, it lacks {lacks}; {remedy}")
    return frame, metadata
