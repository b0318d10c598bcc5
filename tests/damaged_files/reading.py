"""Read damaged files of every kind, and gather what goes wrong."""

import re
import time
from pathlib import Path

import numpy as np

from jawenv.base.errors import InputError
from tests.damaged_files.formats import FORMATS, Format

LONGEST_S = 1.0
"""Of computing; a machine that others use may take ten times that."""
LONGEST_LINE = 800
KINDS = ("bits", "cut", "value", "zeros")
VALUES = (b"-1", b"0", b"1e999", b"nan", b"9" * 5000, b"null", b"[]", b"{}", b"''", b"true", b"1e-320")


def damaged(content: bytes, kind: str, rng: np.random.Generator) -> bytes:
    """The content with one damage of a kind."""
    made = bytearray(content)
    if kind == "bits":
        for bit in rng.integers(8 * len(made), size=int(rng.integers(1, 40))):
            made[bit // 8] ^= 1 << (bit % 8)
    elif kind == "cut":
        del made[int(rng.integers(len(made))) :]
    elif kind == "value":
        numbers = list(re.finditer(rb"[-+]?\d[\d.]*(?:e[-+]?\d+)?", content))
        if numbers:
            chosen = numbers[int(rng.integers(len(numbers)))]
            made[chosen.start() : chosen.end()] = VALUES[int(rng.integers(len(VALUES)))]
    else:
        a, b = sorted(int(place) for place in rng.integers(0, len(made) + 1, size=2))
        made[a:b] = bytes(b - a)
    return bytes(made)


def faults_of(format_: Format, folder: Path, number: int, seed: int) -> tuple[list[str], int]:
    """Damage a file of a kind again and again.

    Args:
        format_: the kind.
        folder: an empty one.
        number: of damaged files.
        seed: of the damages.

    Returns:
        What went wrong, and how many damaged files were refused.
    """
    format_.make(folder)
    whole = {path: path.read_bytes() for path in folder.iterdir()}
    place = folder / format_.file
    content = format_.inner(whole[place])
    right = format_.read(folder)
    faults, refused = [], 0
    for k in range(number):
        kind = KINDS[k % len(KINDS)]
        changed = damaged(content, kind, np.random.default_rng([seed, k]))
        for path, held in whole.items():
            path.write_bytes(held)
        format_.put(place, changed)
        problem, was_refused = _read(format_, folder, right)
        refused += was_refused
        if problem:
            faults.append(f"{format_.name}, damage {k} of seed {seed} ({kind}): {problem}")
    return faults, refused


def _read(format_: Format, folder: Path, right: object) -> tuple[str, bool]:
    start, begun, problem, refused = time.monotonic(), time.process_time(), "", False
    try:
        told = format_.read(folder)
        if format_.has_checksums and told != right:
            problem = "is read as something else"
    except InputError as error:
        refused, line = True, str(error)
        if "\n" in line or not line or len(line) > LONGEST_LINE:
            problem = f"is not refused in one line: {line[:200]!r}"
    except Exception as error:
        problem = f"{type(error).__name__}: {str(error)[:200]!r}"
    computed, elapsed = time.process_time() - begun, time.monotonic() - start
    if computed > LONGEST_S or elapsed > 10.0 * LONGEST_S:
        problem += f" takes {elapsed:.1f} s"
    return problem, refused


__all__ = ["FORMATS", "faults_of"]
