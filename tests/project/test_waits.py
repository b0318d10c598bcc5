"""No test waits for a process for ever."""

import ast
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
FILES = [path for path in sorted(TESTS.rglob("*.py")) if "subprocess" in path.read_text(encoding="utf-8")]


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(TESTS)))
def test_every_wait_for_a_process_has_an_end(path: Path) -> None:
    for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(call, ast.Call) and ast.unparse(call.func).startswith("subprocess."):
            assert call.func.attr != "Popen" or path.name == "processes.py", "allowed: tests.processes.started"
            assert call.func.attr != "run" or "timeout" in {keyword.arg for keyword in call.keywords}, call.lineno
