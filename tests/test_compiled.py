"""Kernels from the cache are those of their own types, whichever process compiled them."""

import os
import subprocess
import sys
from pathlib import Path

import jawenv

# The inner kernel calls itself, and so stays a function of its own, which the outer calls by its symbol.
KERNELS = """
import sys

import numpy as np

from jawenv.compiled import njit


@njit
def total(record, times):
    if times == 0:
        return 0.0
    value = 0.0
    for i in range(record.values.shape[0]):
        value += record.values[i]
    return value + total(record, times - 1)


@njit
def outer(records, times):
    return total(records[0], times)


for size in sys.argv[1:]:
    records = np.ones(1, dtype=np.dtype([("values", "f8", int(size))]))
    print(outer(records, 2))
"""


def test_two_processes_may_fill_the_cache_for_a_third(tmp_path: Path) -> None:
    """Twice the sum of ones, of which a record has as many as its type says."""
    (tmp_path / "kernels.py").write_text(KERNELS)
    places = {"JAWENV_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(Path(jawenv.__file__).parents[1])}

    def sums(*sizes: str) -> list[float]:
        command = [sys.executable, str(tmp_path / "kernels.py"), *sizes]
        ran = subprocess.run(command, env=os.environ | places, capture_output=True, text=True, check=True)
        return [float(line) for line in ran.stdout.split()]

    assert sums("3") == [6.0]
    assert sums("5") == [10.0]
    assert sums("3", "5") == [6.0, 10.0]
    assert sums("5", "3") == [10.0, 6.0]
