"""Read damaged files of every kind, and gather what goes wrong."""

import time
from pathlib import Path

import numpy as np
from damages import KINDS, damaged
from file_formats import FORMATS, Format

from jawenv.errors import InputError

LONGEST_S = 1.0
"""Of computing; a machine that others use may take ten times that."""
LONGEST_LINE = 800


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
