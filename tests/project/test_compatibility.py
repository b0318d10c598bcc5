"""docs/tables/compatibility.md has a row for every test of tests/foreign, and none that failed."""

import ast
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "tables" / "compatibility.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| (\S+) \| (\S+) \| (.+?) \| (.+?) \|$", PAGE, flags=re.M)[1:]


def functions() -> dict[str, str]:
    """What each test runs, in its docstring -> the library of its module."""
    found = {}
    for path in sorted((ROOT / "tests" / "foreign").glob("test_*.py")):
        text = path.read_text(encoding="utf-8")
        (library,) = re.findall(r'\blibrary\("(\w+)"\)', text)
        for node in ast.parse(text).body:
            if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
                doc = ast.get_docstring(node)
                assert doc, f"{path.name}: {node.name} does not say what it runs"
                found[" ".join(doc.split())] = library
    return found


def test_every_test_has_its_row() -> None:
    assert {what: library for library, _, what, _ in ROWS} == functions(), "run: python docs/site/compatibility.py"
