"""Run tests/foreign and write the table of docs/tables/compatibility.md: ``python docs/site/compatibility.py``.

A row is a test function: its library, the version that is installed, the test's docstring, and how many of its cases
passed, failed or were skipped. What is not installed is skipped, so install the group ``foreign`` first. The exit code
is that of the tests.
"""

from __future__ import annotations

import re
import sys
from collections import Counter
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "tables" / "compatibility.md"
_BLOCK = re.compile(r"(<!-- table: compatibility -->\n).*?(<!-- end of table -->)", re.DOTALL)
Row = tuple[str, str]  # library, what was run


class Results:
    """Pytest's results by row."""

    def __init__(self) -> None:
        self.counts: dict[Row, Counter[str]] = {}
        self._rows: dict[str, Row] = {}

    def pytest_collection_modifyitems(self, items: list[Any]) -> None:
        """Keep the row of each test."""
        for item in items:
            marker = item.get_closest_marker("library")
            self._rows[item.nodeid] = (marker.args[0], " ".join(item.function.__doc__.split()))

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Count a case, when it was called, or skipped or failed before or after."""
        if report.when == "call" or report.outcome != "passed":
            self.counts.setdefault(self._rows[report.nodeid], Counter())[report.outcome] += 1


def table(counts: dict[Row, Counter[str]]) -> str:
    """The rows by library, in the order of the tests."""
    lines = ["| library | version | what was run | result |", "|---|---|---|---|"]
    for (library, what), outcomes in sorted(counts.items(), key=lambda row: row[0][0]):
        result = ", ".join(f"{number} {outcome}" for outcome, number in sorted(outcomes.items()))
        lines.append(f"| {library} | {_version(library)} | {what} | {result} |")
    return "\n".join(lines) + "\n"


def _version(library: str) -> str:
    try:
        return version(library).split("+")[0]
    except PackageNotFoundError:
        return "–"


def main() -> int:
    """Run the tests, renew the table."""
    results = Results()
    every_case = ["-m", "foreign"]  # also those that repeat others, which pyproject.toml leaves out
    arguments = ["-q", "-p", "no:cacheprovider", *every_case, str(ROOT / "tests" / "foreign")]
    code = pytest.main(arguments, plugins=[results])
    if results.counts:
        text = PAGE.read_text(encoding="utf-8")
        PAGE.write_text(_BLOCK.sub(lambda block: block[1] + table(results.counts) + block[2], text), encoding="utf-8")
    return int(code)


if __name__ == "__main__":
    if sys.argv[1:]:
        raise SystemExit("usage: python docs/site/compatibility.py")
    raise SystemExit(main())
