"""Read damaged files of every kind, and gather what goes wrong."""

import re
import time
from pathlib import Path

import numpy as np

from jawenv.base.errors import InputError
from tests.damaged_files.formats import FORMATS, Format

LONGEST_S = 1.0
"""Longest computing time; a machine that others use may take ten times that."""
LONGEST_LINE = 800
_TOKEN = re.compile(rb"[-+]?\d[\d.]*(?:e[-+]?\d+)?|[A-Za-z_]{2,}|\"[^\"\n]*\"")
_VALUES = (
    *(b"-1", b"0", b"1e308", b"1e999", b"1e-320", b"nan", b"9" * 400, b"9" * 5000, b"4294967296", b"0x10", b"1_000"),
    *(b"null", b"true", b"[]", b"{}", b"''", b"[[[[[1]]]]]", b"{a: {b: 1}}", b"2026-01-01", b"1,5", b"=1+1"),
    *(b"\xff\xfe", b"\x00", b"\xc2\xa0", b"\xe2\x80\xae", b"'\\u001b[2J'", b"!!python/object/apply:os.system [x]"),
    *(b"*a", b"&a [1]", b"<<"),
)
_WORDS = (b"\xff" * 4, bytes(4), b"\xff\xff\xff\x7f", b"\x00\x00\x00\x80", b"\x01\x00\x00\x00", b"\xff" * 8)


def _others(made: bytearray, rng: np.random.Generator) -> None:
    """Numbers, words and quoted texts become something of another type."""
    for _ in range(int(rng.integers(1, 4))):
        if tokens := list(_TOKEN.finditer(made[:400_000])):
            token = tokens[int(rng.integers(len(tokens)))]
            made[token.start() : token.end()] = _VALUES[int(rng.integers(len(_VALUES)))]


def _lines(made: bytearray, rng: np.random.Generator) -> None:
    """Two lines are exchanged, and one of them is there twice."""
    lines = bytes(made).split(b"\n")
    i, j = (int(place) for place in rng.integers(len(lines), size=2))
    lines[i], lines[j] = lines[j], lines[i]
    made[:] = b"\n".join([*lines[:i], lines[j], *lines[i:]])


def _lost(made: bytearray, rng: np.random.Generator) -> None:
    """A block is gone, or all from there on."""
    start = int(rng.integers(len(made)))
    del made[start : start + int(rng.integers(1, 200)) if rng.random() < 0.7 else len(made)]


def _moved(made: bytearray, rng: np.random.Generator) -> None:
    """A block stands elsewhere once more."""
    to, start = (int(place) for place in rng.integers(len(made) + 1, size=2))
    made[to:to] = made[start : start + int(rng.integers(1, 300))]


def _extremes(made: bytearray, rng: np.random.Generator) -> None:
    """Words of 32 bits are the largest and smallest of their kinds."""
    for _ in range(int(rng.integers(1, 6))):
        start, word = int(rng.integers(max(1, len(made) - 8))), _WORDS[int(rng.integers(len(_WORDS)))]
        made[start : start + len(word)] = word


def _repeated(made: bytearray, rng: np.random.Generator) -> None:
    """The end is there many times."""
    made += made[-int(rng.integers(1, 2000)) :] * int(rng.integers(1, 20))


KINDS = (_others, _lines, _others, _lost, _moved, _others, _extremes, _repeated)


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
        changed = bytearray(content)
        kind(changed, np.random.default_rng([seed, k]))
        for path, held in whole.items():
            path.write_bytes(held)
        format_.put(place, bytes(changed))
        problem, was_refused = _read(format_, folder, right)
        refused += was_refused
        if problem:
            faults.append(f"{format_.name}, damage {k} of seed {seed} ({kind.__name__}): {problem}")
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
