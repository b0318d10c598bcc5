"""The page in a cell of a notebook."""

import urllib.request

import pytest

from jawenv.base.errors import InputError
from jawenv.live.notebook import Cell


def test_a_cell_holds_the_page_and_drives_until_it_is_stopped(tmp_path):
    cell = Cell("slow_opening", tmp_path, 500, seed=500, episode_s=600.0)
    address = cell._repr_html_().split('"')[1]
    assert cell._repr_html_().startswith("<iframe ") and 'height="500"' in cell._repr_html_()
    with urllib.request.urlopen(address, timeout=30) as page:
        assert b"<html" in page.read(200)
    cell.stop()
    steps = cell.page.steps
    assert cell.page.session.driver == "slow_opening" and steps >= 0
    cell.stop()
    with pytest.raises(OSError):
        urllib.request.urlopen(address, timeout=5)


def test_what_is_refused_leaves_no_server(tmp_path):
    with pytest.raises(InputError):
        Cell("nobody", tmp_path)
    with pytest.raises(InputError):
        Cell(cohort="knees")
