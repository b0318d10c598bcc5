"""Fixtures for all tests; that this file exists also makes the helpers beside it (``newton_euler``) importable."""

import numpy as np
import pytest
from hypothesis import settings

from jawenv.mechanics import build_jaw

# No deadline: the first call compiles, and machines are shared. Always the same examples.
settings.register_profile("jawenv", deadline=None, derandomize=True)
settings.load_profile("jawenv")

# Begun first, in this order, so that no process is left with a long file when the others have nothing more to do. The
# first compiles the models of the ladder one after the other, while another process compiles the default model.
LONG = (
    "tests/envs/test_every_model.py",
    "tests/eval/studies/test_run.py",
    "eval/notebooks/",
    "tests/project/",
    "tests/training/",
    "tests/estimation/",
    "tests/acceptance/",
    "tests/eval/",
)


def pytest_collection_modifyitems(items):
    """Sort the files as ``LONG`` says; the order within a file stays."""
    last = len(LONG)
    items.sort(key=lambda item: next((i for i, place in enumerate(LONG) if item.nodeid.startswith(place)), last))


@pytest.fixture
def jaw():
    """The default jaw, the test's own: its fields may be overwritten."""
    return build_jaw()


@pytest.fixture
def rng():
    return np.random.default_rng(20_160_101)
