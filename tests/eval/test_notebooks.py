import json
import re
from pathlib import Path

import pytest

import eval

NOTEBOOKS = sorted((Path(eval.__file__).parent / "notebooks").glob("*.ipynb"))


def code_of(path):
    """The source of each cell of code."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_holds_no_output(path):
    assert not any(cell.get("outputs") for cell in json.loads(path.read_text(encoding="utf-8"))["cells"])


@pytest.mark.parametrize("number", ["01", "02", "04"])
def test_a_notebook_that_does_not_train_needs_the_wheel_alone(number):
    (path,) = (path for path in NOTEBOOKS if path.stem.startswith(number))
    code = "\n".join(code_of(path))
    assert not re.search(r"^\s*(?:import|from) (?:agents|training|eval)\b", code, re.M)
