import re
from pathlib import Path

import jupytext
import pytest

import eval

NOTEBOOKS = sorted((Path(eval.__file__).parent / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_and_its_script_say_the_same_and_hold_no_output(path):
    notebook, script = jupytext.read(path), jupytext.read(path.with_suffix(".py"))
    assert [(cell.cell_type, cell.source) for cell in notebook.cells] == [
        (cell.cell_type, cell.source) for cell in script.cells
    ]
    assert not any(cell.get("outputs") for cell in notebook.cells)


@pytest.mark.parametrize("number", ["01", "02", "04"])
def test_a_notebook_that_does_not_train_needs_the_wheel_alone(number):
    (path,) = (path for path in NOTEBOOKS if path.stem.startswith(number))
    code = "\n".join(cell.source for cell in jupytext.read(path).cells if cell.cell_type == "code")
    assert not re.search(r"^\s*(?:import|from) (?:agents|training|eval)\b", code, re.M)
