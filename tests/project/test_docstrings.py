"""First lines of docstrings say what the code does: a noun or a verb, no clause for a noun, nothing turned round."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROOMS = ("eval", "jawenv", "agents", "training", "research")
"""Folders that are held to it."""
TURNED_ROUND = {
    "a clause for a noun": r"^(Which|What|How|Who|Whose|When|Where)\b",
    "no subject": r"^(Of|As|From|In|On|At|By|With|Without|After|Before|For)\b",
    "a pronoun for a noun": r"\b(those (that|who)|the ones? (that|who)|as \w+ has it)\b",
    "a negated clause": r"\b(that|which|who) (is|are|was|were|do|does|did|has|have|can) not\b",
}


def turned_round(text: str) -> list[str]:
    """The first lines of a source that are turned round, each with its fault."""
    kinds = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
    docs = (ast.get_docstring(node) or "" for node in ast.walk(ast.parse(text)) if isinstance(node, kinds))
    lines = [doc.split("\n")[0] for doc in docs]
    return [f"{fault}: {line}" for line in lines for fault, form in TURNED_ROUND.items() if re.search(form, line)]


@pytest.mark.parametrize("room", ROOMS)
def test_no_first_line_is_turned_round(room):
    found = {path: turned_round(path.read_text(encoding="utf-8")) for path in (ROOT / room).rglob("*.py")}
    assert not {str(path.relative_to(ROOT)): lines for path, lines in found.items() if lines}


@pytest.mark.parametrize(
    "line",
    [
        "What has to be known.",
        "As tables call it.",
        "Times, those who never get there counted as the length.",
        "The rows that are not ranked.",
    ],
)
def test_a_line_that_is_turned_round_is_found(line):
    assert len(turned_round(f'"""{line}"""')) == 1
