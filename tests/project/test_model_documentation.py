"""The model's page and tables have the figures, numbers and errors of printed equations that the code makes."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "model.md"
TEXT = PAGE.read_text(encoding="utf-8")
FIGURES = ROOT / "docs" / "figures"


@pytest.fixture(autouse=True)
def paths(monkeypatch: pytest.MonkeyPatch) -> None:
    for folder in (ROOT / "tests" / "validation", FIGURES):
        monkeypatch.syspath_prepend(str(folder))


def test_tables_are_those_of_the_data_and_the_code() -> None:
    import tables

    text = "".join(page.read_text(encoding="utf-8") for page in tables.PAGES)
    assert sorted(re.findall(r"<!-- table: (\w+) -->", text)) == sorted(tables.TABLES)
    assert tables.renewed(text) == text, "run: python docs/figures/tables.py"


def test_the_page_shows_every_figure_in_order() -> None:
    import make

    shown = re.findall(r"!\[[^\]]+\]\(figures/(\w+)\.svg\)", TEXT)
    assert sorted(shown) == sorted(make.FIGURES)
    numbers = [int(n) for n in re.findall(r"^\*Figure (\d+)\.", TEXT, re.M)]
    assert numbers == list(range(1, len(shown) + 1))
    for name in shown:
        assert (FIGURES / f"{name}.svg").stat().st_size < 300_000


@pytest.mark.parametrize("name", ["frames", "muscle_law", "muscle_lines", "condyle_path"])
def test_a_figure_can_be_made(name: str, tmp_path: Path) -> None:
    """Those of the anatomy; the others show the runs of other tests."""
    import make

    drawn = make.make(name, tmp_path).read_bytes()
    assert b"<svg" in drawn and b"<dc:date>" not in drawn


def test_errors_of_the_printed_equations() -> None:
    from printed_equations import errors_of_printed_equations

    text = (ROOT / "docs" / "tables" / "model.md").read_text(encoding="utf-8")
    block = text.split("<!-- printed equations -->")[1].strip().split("\n\n")[0].splitlines()[2:]
    stated = [[cell.strip() for cell in line.strip("|").split("|")] for line in block]
    rows = errors_of_printed_equations()
    assert [(cells[0], cells[1], cells[4]) for cells in stated] == [(r.equation, r.fault, r.unit) for r in rows]
    for cells, row in zip(stated, rows, strict=True):
        assert float(cells[2]) == pytest.approx(row.median, rel=0.01)
        assert float(cells[3]) == pytest.approx(row.largest, rel=0.01)
