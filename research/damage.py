"""Read thousands of damaged files of every kind, with bounded memory, and print what went wrong.

    python -m research.damage --files 3000 --seed 7

Ends with 1 where a damaged file gave a traceback, a wrong content in spite of checksums, took more than a second, or
more memory than a gigabyte.
"""

import argparse
import resource
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from tests.damaged_files.reading import FORMATS, faults_of

MEMORY = 2**30
"""Bytes of address space beyond what the program takes for whole files."""


def main() -> int:
    """Read them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--files", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=7)
    arguments = parser.parse_args()
    files = -(-arguments.files // len(FORMATS))
    faults: list[str] = []
    refused: Counter[str] = Counter()
    start = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        for format_ in FORMATS:  # what reading a whole file loads is not counted
            (Path(folder) / format_.name).mkdir()
            faults_of(format_, Path(folder) / format_.name, 0, arguments.seed)
        _limit_memory()
        for format_ in FORMATS:
            some, refused[format_.name] = faults_of(format_, Path(folder) / format_.name, files, arguments.seed)
            faults += some
            print(f"{format_.name:30s} {files} files, {refused[format_.name]} refused, {len(some)} faults", flush=True)
    print("\n".join(faults[:100]))
    print(f"{files * len(FORMATS)} damaged files, {len(faults)} faults, {time.monotonic() - start:.0f} s")
    return 1 if faults else 0


def _limit_memory() -> None:
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = pages * resource.getpagesize() + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


if __name__ == "__main__":
    sys.exit(main())
