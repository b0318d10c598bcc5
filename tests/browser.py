"""A browser for pages that are explored: headless Chromium, driven by Playwright, started once in a process."""

import functools
import shutil

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
REMEDY = "no Chromium found: install one (Debian: apt install chromium)"
# Nothing but the page, which these browsers draw without a graphics card.
FLAGS = (
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)


def executable() -> str:
    """The path of an installed Chromium; skips the test where there is none."""
    found = next((path for path in map(shutil.which, NAMES) if path), None)
    if found is None:
        pytest.skip(REMEDY)
    return found


@functools.cache
def _started():
    from playwright.sync_api import sync_playwright

    playwright = sync_playwright().start()
    return playwright, playwright.chromium.launch(executable_path=executable(), args=list(FLAGS))


def browser():
    """The browser of this process; skips the test where there is none."""
    executable()
    return _started()[1]


def close():
    """End the browser, if one was started."""
    if _started.cache_info().currsize:
        playwright, started = _started()
        _started.cache_clear()
        started.close()
        playwright.stop()


def new_page(**options):
    """A page of its own with what it says on the console and asks of the network in ``complaints`` and ``requests``."""
    page = browser().new_page(**options)
    page.complaints, page.requests = [], []
    page.on("console", lambda message: page.complaints.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: page.complaints.append(str(error)))
    page.on("request", lambda request: page.requests.append(request.url))
    return page
