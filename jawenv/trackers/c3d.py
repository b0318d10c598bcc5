"""C3D files (https://www.c3d.org), read by their bytes: what a file states of its sizes is checked before it is used.

Numbers are of Intel's, MIPS's or DEC's order. Points are 32-bit floats where POINT:SCALE is negative, else integers.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from jawenv.base.errors import InputError, shown
from jawenv.base.reading import read_bytes
from jawenv.recordings.columns import TIME
from jawenv.recordings.table import LARGEST_RECORDING, RecordTable
from jawenv.trackers.tracks import Tracks, distinct, is_rate, millimetres

BLOCK = 512
"""Bytes."""
KEY = 80
"""Second byte of every C3D file."""
WORDS = 4
"""Words of a point: three coordinates and its residual, which is negative where the point was lost."""
COUNTED = 65_535
"""Frames that a header can count; longer files hold as many as there are."""


@dataclass(frozen=True)
class Processor:
    """Form in which the numbers of a file are written."""

    order: str  # of the bytes, ``<`` or ``>``
    dec: bool = False  # whether floats are those of a VAX

    def unpack(self, content: bytes, kind: str, at: int) -> tuple[Any, ...]:
        """Numbers of kinds h, H or f at a place."""
        size = struct.calcsize(self.order + kind)
        if kind == "f":
            return tuple(self.array(content[at : at + size], "f4").tolist())
        return struct.unpack_from(self.order + kind, content, at)

    def array(self, content: bytes, kind: str) -> Any:
        """Numbers of kinds i2, u2 or f4."""
        if self.dec and kind == "f4":
            halves = np.frombuffer(content, "<u2").reshape(-1, 2)[:, ::-1]
            return np.ascontiguousarray(halves).view("<f4")[:, 0] / np.float32(4.0)
        return np.frombuffer(content, self.order + kind)


PROCESSORS = {84: Processor("<"), 85: Processor("<", dec=True), 86: Processor(">")}


def read_c3d(path: Path, unit: str | None) -> Tracks:
    """Read the points and the analog channels of a C3D file."""
    content = read_bytes(path, LARGEST_RECORDING)
    if len(content) < BLOCK or content[1] != KEY or content[0] < 2:
        raise InputError(f"{path}: begins with {shown(content[:2])}; allowed: a C3D file")
    try:
        return _tracks(content, path, unit)
    except InputError:
        raise
    except (struct.error, ValueError, IndexError, KeyError, OverflowError, ZeroDivisionError) as error:
        why = f"{type(error).__name__} {' '.join(str(error).split())[:80]}"
        raise InputError(f"{path}: its parameters are damaged ({why}); allowed: a whole C3D file") from None


def _tracks(content: bytes, path: Path, unit: str | None) -> Tracks:
    start = (content[0] - 1) * BLOCK
    processor = PROCESSORS[content[start + 3]]
    stated = _parameters(content, start, processor)
    points, measurements, first, last = processor.unpack(content, "4H", 2)
    data_start, per_frame = processor.unpack(content, "2H", 16)
    points = int(_one(stated, "POINT:USED", points)) & COUNTED
    scale = float(_one(stated, "POINT:SCALE", processor.unpack(content, "f", 12)[0]))
    rate = float(_one(stated, "POINT:RATE", processor.unpack(content, "f", 20)[0]))
    if not is_rate(rate):
        raise InputError(f"{path}: POINT:RATE is {rate:g}; allowed: a number above 0")
    if not np.isfinite(scale) or data_start < 2 or points < 1:
        raise InputError(f"{path}: POINT:SCALE, USED or DATA_START is damaged; allowed: a whole C3D file with points")
    words, kind = WORDS * points + measurements, "f4" if scale < 0.0 else "i2"
    if kind == "i2" and str(_one(stated, "ANALOG:FORMAT", "")).upper().startswith("UNSIGNED"):
        kind = "u2"
    body, size = content[(data_start - 1) * BLOCK :], words * int(kind[1])
    frames = _frames(stated, last - first + 1)
    if frames >= COUNTED:
        frames = len(body.rstrip(b"\0")) // size + bool(len(body.rstrip(b"\0")) % size)
    if len(body) < frames * size:
        needed = len(content) - len(body) + frames * size
        raise InputError(f"{path}: has {len(content):,} bytes; allowed: {needed:,} or more (a truncated file?)")
    rows = processor.array(body[: frames * size], kind).reshape(frames, words)
    seen = rows[:, : WORDS * points].reshape(frames, points, WORDS)
    if kind == "u2":
        seen = seen.view(f"{processor.order}i2")
    factor = millimetres(unit or str(_one(stated, "POINT:UNITS", "")), str(path))
    with np.errstate(invalid="ignore", over="ignore"):  # of damaged numbers
        places = seen[:, :, :3].astype(np.float64) * (factor if scale < 0.0 else factor * scale)
    places[~(seen[:, :, 3] >= 0.0)] = np.nan
    labels = _several(stated, "POINT:LABELS")[:points]
    named = {name: places[:, i] for i, name in enumerate(distinct(labels)) if labels[i]}
    analog = _analog(stated, rows[:, WORDS * points :], (path, rate, per_frame))
    return Tracks(str(path), np.arange(frames) / rate, named, analog=analog)


def _frames(stated: Mapping[str, list[Any]], counted: int) -> int:
    """Number of frames that the file states; ``COUNTED`` or more where it cannot say."""
    ends = [stated.get(f"TRIAL:ACTUAL_{end}_FIELD", []) for end in ("START", "END")]
    if all(len(words) == 2 for words in ends):
        begin, end = (int(low) % 2**16 + 2**16 * (int(high) % 2**16) for low, high in ends)
        return int(np.clip(end - begin + 1, 0, 2**31))
    frames = int(_one(stated, "POINT:FRAMES", counted))
    return frames % 2**16 if frames < 0 else frames


def _analog(stated: Mapping[str, list[Any]], rows: Any, where: tuple[Path, float, int]) -> RecordTable | None:
    """The named analog channels in their own units, on the clock of the points."""
    path, rate, per_frame = where
    if rows.shape[1] == 0:
        return None
    channels = rows.shape[1] // max(per_frame, 1)
    if channels * per_frame != rows.shape[1] or int(_one(stated, "ANALOG:USED", channels)) != channels:
        raise InputError(f"{path}: ANALOG:USED is damaged; allowed: {channels}, as in the header")
    general = float(_one(stated, "ANALOG:GEN_SCALE", 1.0))
    scales = np.array(stated.get("ANALOG:SCALE") or [1.0] * channels, dtype=np.float64)[:channels]
    offsets = np.array(stated.get("ANALOG:OFFSET") or [0] * channels, dtype=np.float64)[:channels]
    if rows.dtype.kind == "u":
        offsets %= 2**16
    with np.errstate(invalid="ignore", over="ignore"):
        values = (rows.reshape(-1, channels).astype(np.float64) - offsets) * scales * general
    labels, units = (_several(stated, f"ANALOG:{name}")[:channels] for name in ("LABELS", "UNITS"))
    columns = {name: values[:, i] for i, name in enumerate(distinct(labels)) if labels[i]}
    columns[TIME] = np.arange(len(values)) / (rate * per_frame)
    return RecordTable(
        str(path), columns, np.arange(1, len(values) + 1), {}, dict(zip(distinct(labels), units, strict=False))
    )


def _one(stated: Mapping[str, list[Any]], name: str, default: Any) -> Any:
    values = stated.get(name) or [default]
    return values[0]


def _several(stated: Mapping[str, list[Any]], name: str) -> list[str]:
    """Texts of a parameter, and of all that go on with it: LABELS, LABELS2, LABELS3 ..."""
    texts, number = list(stated.get(name, [])), 2
    while f"{name}{number}" in stated:
        texts += stated[f"{name}{number}"]
        number += 1
    return [str(text) for text in texts]


def _parameters(content: bytes, start: int, processor: Processor) -> dict[str, list[Any]]:
    """Values of the groups POINT, ANALOG and TRIAL, by GROUP:NAME."""
    groups: dict[int, str] = {}
    found: list[tuple[int, str, int]] = []
    at = start + 4
    while at + 2 <= len(content) and content[at] != 0:
        length, group = struct.unpack_from("bb", content, at)
        name = content[at + 2 : at + 2 + abs(length)].decode("latin-1").upper()
        at += 2 + abs(length)
        (step,) = processor.unpack(content, "H", at)
        if group < 0:
            groups[-group] = name
        else:
            found.append((group, name, at + 2))
        if step < 2:
            break
        at += step
    wanted = [(f"{groups.get(group)}:{name}", at) for group, name, at in found]
    return {
        name: _value(content, at, processor)
        for name, at in wanted
        if name.startswith(("POINT:", "ANALOG:", "TRIAL:")) and not name.endswith("DESCRIPTIONS")
    }


def _value(content: bytes, at: int, processor: Processor) -> list[Any]:
    """Texts or numbers of a parameter."""
    kind, dimensions = struct.unpack_from("bB", content, at)
    sizes = list(content[at + 2 : at + 2 + dimensions])
    number, width = math.prod(sizes), max(abs(kind), 1)
    begin = at + 2 + dimensions
    data = content[begin : begin + number * width] if number <= len(content) else b""
    if kind not in (-1, 1, 2, 4) or len(sizes) != dimensions or len(data) != number * width:
        raise ValueError(f"sizes {sizes[:3]}")
    if kind == -1:
        length = max(sizes[0] if sizes else 1, 1)
        return [data[i : i + length].decode("utf-8", "replace").strip(" \0") for i in range(0, number, length)]
    if kind == 1:
        return list(data)
    values: list[Any] = processor.array(data, "i2" if kind == 2 else "f4").tolist()
    return values
