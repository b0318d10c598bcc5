"""A report in the browser that tests share."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tests.browser import new_page


@contextmanager
def opened(path: Path, width: int = 1400, scheme: str = "light") -> Iterator:
    """A report whose charts are drawn, with ``page.complaints`` and ``page.requests``."""
    page = new_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
    try:
        page.goto(path.as_uri())
        page.wait_for_function("document.querySelectorAll('.chart .main-svg').length > 0")
        yield page
    finally:
        page.context.close()
