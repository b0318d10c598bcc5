"""A command without the packages of its extra says in one line how to install them."""

import subprocess
import sys
from pathlib import Path

import pytest

from training.extra import installed

ROOT = Path(__file__).parents[2]
RUNS = """
import runpy, sys
sys.modules[{package!r}] = None
sys.argv = [{command!r}, *{arguments!r}]
runpy.run_module({command!r}, run_name="__main__")
"""


@pytest.mark.parametrize(
    ("command", "extra", "package", "arguments"),
    [
        ("eval", "eval", "pandas", ["compare", "hold_still"]),
        ("training", "train", "torch", ["train", "ppo"]),
    ],
)
def test_the_extra_is_named(command: str, extra: str, package: str, arguments: list[str]) -> None:
    code = RUNS.format(package=package, command=command, arguments=arguments)
    ran = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    remedy = f'pip install -e ".[{extra}]", or .ci/setup {extra}'
    assert ran.stderr == f"error: python -m {command} needs {package}: {remedy}\n"
    assert ran.returncode == 2


def test_a_missing_module_of_the_project_is_no_missing_package() -> None:
    with pytest.raises(ModuleNotFoundError, match="training.nothing"), installed("python -m training", "train"):
        import training.nothing  # type: ignore[import-not-found]  # noqa: F401
