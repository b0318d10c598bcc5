"""Functions take few parameters: what belongs together is a record that says what it is."""

import ast

import pytest
from documented import ROOT

MOST = 8
FOLDERS = ("jawenv", "agents", "training", "eval", "examples", "tests", "docs")
# Of commands each parameter is an option of the command line.
COMMANDS = {
    "benchmark_command",
    "calibrate_command",
    "compare_command",
    "dataset_command",
    "design",
    "diagnose_command",
    "distill",
    "information_command",
    "live_command",
    "optimise",
    "patient_command",
    "play_command",
    "replay_command",
    "score_command",
    "train",
}
# The public function that reads a recording: its options are given by name alone.
PUBLIC = {"load_record"}


def parameters(function: ast.FunctionDef | ast.AsyncFunctionDef) -> list[str]:
    """Names of all parameters but ``self`` and ``cls``."""
    given = function.args
    named = [*given.posonlyargs, *given.args, *given.kwonlyargs, *filter(None, (given.vararg, given.kwarg))]
    return [argument.arg for argument in named if argument.arg not in ("self", "cls")]


def too_long(text: str) -> dict[str, int]:
    """Name -> parameters, of functions with too many of them; constructors whose options have names are left out."""
    found = {}
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            names = parameters(node)
            if len(names) > MOST and not (node.name == "__init__" and node.args.kwonlyargs):
                found[node.name] = len(names)
    return found


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("def f(a, b, c, d, e, f, g, h): ...", {}),
        ("def f(a, b, c, d, e, f, g, h, i): ...", {"f": 9}),
        ("def f(a, b, c, d, *e, f, g, h, **i): ...", {"f": 9}),
        ("class A:\n    def f(self, a, b, c, d, e, f, g, h): ...", {}),
        ("class A:\n    def __init__(self, a, *, b, c, d, e, f, g, h, i): ...", {}),
        ("class A:\n    def __init__(self, a, b, c, d, e, f, g, h, i): ...", {"__init__": 9}),
    ],
)
def test_what_is_too_long(text: str, found: dict[str, int]) -> None:
    assert too_long(text) == found


def test_functions_take_few_parameters() -> None:
    found: dict[str, int] = {}
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            found |= too_long(path.read_text(encoding="utf-8"))
    assert {name: count for name, count in found.items() if name not in COMMANDS | PUBLIC} == {}
