"""Damages of a file's content, each decided by a seed."""

import re

import numpy as np

HEAD = 128
VALUES = (b"-1", b"0", b"1e999", b"nan", b"9" * 25, b"9" * 5000, b"null", b"[]", b"{}", b"''", b"true", b"1e-320")
KINDS = ("bit", "bits", "cut", "swap", "head", "repeat", "value", "zeros")


def damaged(content: bytes, kind: str, rng: np.random.Generator) -> bytes:
    """The content with one damage of a kind."""
    made = bytearray(content)
    if kind == "bit":
        _flip(made, int(rng.integers(8 * len(made))))
    elif kind == "bits":
        for bit in rng.integers(8 * len(made), size=int(rng.integers(2, 40))):
            _flip(made, int(bit))
    elif kind == "cut":
        del made[int(rng.integers(len(made))) :]
    elif kind == "swap":
        size = int(rng.integers(1, max(2, len(made) // 3)))
        a, b = (int(place) for place in rng.integers(0, len(made) - size + 1, size=2))
        made[a : a + size], made[b : b + size] = made[b : b + size], made[a : a + size]
    elif kind == "head":
        # Archives and Parquet files have theirs at the end.
        last = len(made) - 1
        for place in rng.integers(0, min(HEAD, len(made)), size=int(rng.integers(1, 6))):
            made[int(place) if rng.random() < 0.5 else last - int(place)] = int(rng.integers(256))
    elif kind == "repeat":
        a, b = sorted(int(place) for place in rng.integers(0, len(made) + 1, size=2))
        made[b:b] = made[a:b]
    elif kind == "value":
        numbers = list(re.finditer(rb"[-+]?\d[\d.]*(?:e[-+]?\d+)?", content))
        if numbers:
            chosen = numbers[int(rng.integers(len(numbers)))]
            made[chosen.start() : chosen.end()] = VALUES[int(rng.integers(len(VALUES)))]
    else:
        a, b = sorted(int(place) for place in rng.integers(0, len(made) + 1, size=2))
        made[a:b] = bytes(b - a)
    return bytes(made)


def _flip(content: bytearray, bit: int) -> None:
    content[bit // 8] ^= 1 << (bit % 8)
