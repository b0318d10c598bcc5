"""Fixtures for all tests; that this file exists also makes the helpers beside it (``newton_euler``) importable."""

import signal
import sys

import numba
import numpy as np
import pytest
from hypothesis import settings

from jawenv.mechanics import build_jaw
from tests import browser, compiling

# No deadline: the first call compiles, and machines are shared. Always the same examples.
settings.register_profile("jawenv", deadline=None, derandomize=True)
settings.load_profile("jawenv")


# Compile filters of their own at once: that of JawImaged, and one with a disturbance that has memory.
OWN_FILTERS = ("test_nuisances.py", "test_disturbance.py")
LONG = ("acceptance", "training", "filter")  # folders of the longest tests


def pytest_configure():
    """Interrupts reach tests and their processes also where the shell that began the suite ignores them."""
    compiling.apart()
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(trylast=True)  # those that markers leave out are no longer among them
def pytest_collection_modifyitems(items):
    """Two workers take half of the tests each, in order: one begins with the filter of Jaw, the other with its own.

    Long tests come first in either half, notebooks too, each of which is one: at the end there is something to share.
    """
    own = [item for item in items if item.path.name in OWN_FILTERS]
    notebooks = [item for item in items if item.path.suffix == ".ipynb"]
    rest = [item for item in items if item not in own and item not in notebooks]
    rest.sort(key=lambda item: not set(LONG) & set(item.path.parts[:-1]))
    half = min(len(items) // 2, len(rest))
    items[:] = [*rest[:half], *own, *notebooks, *rest[half:]]


def pytest_collection_finish(session):
    """PyTorch has one thread: several only wait for each other in small networks, and for other workers.

    Tests that set the number of Numba's threads begin these, which set that of PyTorch's: they begin here.
    """
    numba.get_num_threads()
    if "torch" in sys.modules:
        sys.modules["torch"].set_num_threads(1)


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
