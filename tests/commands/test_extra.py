"""A command without the packages of its extra says in one line how to install them."""

from pathlib import Path

import pytest

from tests.processes import python
from training.extra import installed

ROOT = Path(__file__).parents[2]
RUNS = """
import runpy, sys
sys.modules[{package!r}] = None
sys.argv = [{command!r}, *{arguments!r}]
runpy.run_module({command!r}, run_name="__main__")
"""


def test_the_extra_is_named() -> None:
    code = RUNS.format(package="torch", command="training", arguments=["train", "ppo"])
    ran = python("-c", code, cwd=ROOT, check=False)
    assert ran.stderr.startswith("error: python -m training needs torch: .ci/setup ") and ran.stderr.count("\n") == 1
    assert ran.returncode == 2


def test_a_missing_module_of_the_project_is_no_missing_package() -> None:
    with pytest.raises(ModuleNotFoundError, match="training.nothing"), installed("python -m training", "train"):
        import training.nothing  # type: ignore[import-not-found]  # noqa: F401
