"""Fixtures for all tests; that this file exists also makes the helpers beside it (``newton_euler``) importable."""

import numpy as np
import pytest
from hypothesis import settings

from jawenv.mechanics import build_jaw
from tests import browser

# No deadline: the first call compiles, and machines are shared. Always the same examples.
settings.register_profile("jawenv", deadline=None, derandomize=True)
settings.load_profile("jawenv")


@pytest.fixture(scope="session", autouse=True)
def _no_browser_stays():
    """End the browser that tests of pages share."""
    yield
    browser.close()


@pytest.fixture
def jaw():
    """The default jaw, the test's own: its fields may be overwritten."""
    return build_jaw()


@pytest.fixture
def rng():
    return np.random.default_rng(20_160_101)
