"""A few patients of two tasks, played once."""

from pathlib import Path

import pytest

from eval.commands.app import main

CIRCLES = str(Path(__file__).parents[3] / "examples" / "opening_with_circles.yaml")


def play(output, *arguments):
    small = ("--tasks", "hinge-exact", "--patients", "2", "--workers", "1")
    return main(["benchmark", *(arguments or ("slow_opening", CIRCLES)), *small, "--output", str(output)])


@pytest.fixture(scope="session")
def played(tmp_path_factory):
    folder = tmp_path_factory.mktemp("benchmark") / "scores"
    assert play(folder) == 0
    return folder
