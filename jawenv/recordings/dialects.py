"""CSV files as benches and spreadsheets write them: encodings, separators, decimal signs, words for what is missing."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

from jawenv.base.errors import InputError, shown
from jawenv.base.reading import read_bytes

LONGEST_LINE = 65_536
"""Characters of a row of names or numbers."""
SEPARATORS = (";", "\t", ",")
COMMENTS = ("#", "%", "//")
MISSING = frozenset(("", "nan", "na", "n/a", "#n/a", "null", "none", "-", "-nan", "-nan(ind)", "1.#qnan"))
_NUMBER = re.compile(r"[+-]?([0-9]+[.,]?[0-9]*|[.,][0-9]+)([eE][+-]?[0-9]+)?")
_GROUPED = re.compile(r"[1-9][0-9]{0,2}[,.][0-9]{3}")
_INFINITE = re.compile(r"[+-]?inf(inity)?", re.IGNORECASE)


@dataclass(frozen=True)
class _Sheet:
    """The cells of a file."""

    comments: list[tuple[int, str]]  # number and text of the lines that begin with one of ``COMMENTS``, above the names
    names: list[str]  # of the columns
    units: list[str]  # what the row below the names says of their units; empty without such a row
    rows: list[list[str]]  # cells, as many as names
    lines: list[int]  # number of each row in the file


def read_sheet(path: Path, largest: int) -> _Sheet:
    """Read a CSV file of at most so many bytes.

    Comments and empty lines are passed over. A first column without a name, such as the index of pandas, and empty
    columns without one are left out.
    """
    numbered = list(enumerate(decoded(path, largest).splitlines(), 1))
    comments = []
    for number, line in numbered:
        if line.strip() and not line.startswith(COMMENTS):
            break
        comments.append((number, line))
    rows = [(number, line) for number, line in numbered if line.strip() and not line.startswith(COMMENTS)]
    for number, line in rows:
        if len(line) > LONGEST_LINE:
            raise InputError(f"{path}: row {number} has {len(line):,} characters; allowed: {LONGEST_LINE:,} at most")
    separator = ""
    if rows and (directive := re.fullmatch(r"sep=(.)", rows[0][1])):
        separator, rows = directive[1], rows[1:]
    if rows and not separator:
        separator = max(SEPARATORS, key=rows[0][1].count)
    try:
        reader = csv.reader([line for _, line in rows], delimiter=separator or ",", skipinitialspace=True)
        cells = [[cell.strip() for cell in row] for row in reader]
    except csv.Error as error:
        raise InputError(f"{path}: {error}; allowed: CSV") from None
    if len(cells) < len(rows):
        raise InputError(f"{path}: a quotation mark is not closed; allowed: CSV")
    filled = [i for i, row in enumerate(cells) if any(row)]
    cells, lines = [cells[i] for i in filled], [rows[i][0] for i in filled]
    if len(cells) < 2:
        raise InputError(f"{path}: is empty; allowed: a row of column names and two or more rows of numbers")
    return _without_unnamed(path, comments, cells, lines)


def decoded(path: Path, largest: int) -> str:
    """UTF-8, or UTF-16 with its mark, or else the Latin-1 of Windows."""
    data = read_bytes(path, largest)
    encodings = ("utf-16",) if data[:2] in (b"\xff\xfe", b"\xfe\xff") else ("utf-8-sig", "cp1252", "latin-1")
    for encoding in encodings:
        try:
            return data.decode(encoding)
        except UnicodeDecodeError:
            continue
    raise InputError(f"{path}: is no text; allowed: CSV in UTF-8, UTF-16 or Latin-1")


def _without_unnamed(path: Path, comments: list[tuple[int, str]], cells: list[list[str]], lines: list[int]) -> _Sheet:
    names = cells[0]
    for row, line in zip(cells, lines, strict=True):
        if len(row) != len(names):
            few = ", the first row holds their names" if len(row) > len(names) else ""
            raise InputError(f"{path}: row {line} has {len(row)} values; allowed: {len(names)}, one per column{few}")
    named = [
        i
        for i, name in enumerate(names)
        if name or i > 0 and any(row[i] for row in cells)  # an unnamed one with numbers is refused as unknown
    ]
    cells = [[row[i] for i in named] for row in cells]
    units: list[str] = []
    if any(cell.lower() not in MISSING for cell in cells[1]) and not any(map(_is_number, cells[1])):
        units, cells, lines = cells[1], [cells[0], *cells[2:]], [lines[0], *lines[2:]]
    names = cells[0]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{path}: column {shown(name)} stands there twice; allowed: once")
    return _Sheet(comments, names, units, cells[1:], lines[1:])


def _is_number(cell: str) -> bool:
    """Whether a cell holds a number."""
    return bool(_NUMBER.fullmatch(cell) or _INFINITE.fullmatch(cell))


def number(cell: str) -> float | None:
    """The number in a cell, with a decimal point or comma; NaN for a missing one, None for what is neither."""
    if _NUMBER.fullmatch(cell):
        return float(cell.replace(",", "."))
    if cell.lower() in MISSING:
        return float("nan")
    return float(cell) if _INFINITE.fullmatch(cell) else None


def decimal_signs(cells: list[list[str]]) -> set[str]:
    """The decimal signs, point or comma, that stand in the numbers."""
    return {sign for row in cells for cell in row for sign in ".," if sign in cell and _NUMBER.fullmatch(cell)}


def grouped(columns: list[tuple[str, ...]]) -> bool:
    """Whether commas or points may set off thousands: all have three digits behind them, and no lone 0 before.

    With points some column has whole numbers beside: three decimals have them in all rows or in none.
    """
    for sign in ",.":
        marked = [[cell.lstrip("+-") for cell in cells if sign in cell and _is_number(cell)] for cells in columns]
        whole = [any(map(str.isdigit, cells)) for cells in columns]
        if any(marked) and all(_GROUPED.fullmatch(cell) for cells in marked for cell in cells):
            return sign == "," or any(some and beside for some, beside in zip(marked, whole, strict=True))
    return False
