"""The page of ``jawenv live`` in a cell of a notebook that runs on this machine."""

from __future__ import annotations

import contextlib
import threading
from pathlib import Path
from typing import Any

from jawenv.live.page import Page
from jawenv.live.server import serving, url_of
from jawenv.live.session import BY_HAND
from jawenv.live.setup import Setup


class Cell:
    """A jaw that is driven in the cell that ends with this object, until ``stop`` or the end of the notebook.

    Args:
        driver: who drives at first: ``you`` or a maneuver.
        folder: where drives are saved.
        height: of the cell, pixels.
        **settings: `seed`, `env` and arguments of the environment, as those of `jawenv.live.setup.Setup.of`.

    Attributes:
        page: what is shown; its ``session`` holds the environment.

    Raises:
        InputError: a setting or the driver is refused.
        MissingPackageError: viser is not installed.
    """

    def __init__(
        self, driver: str = BY_HAND, folder: Path | str = "runs/live", height: int = 700, **settings: Any
    ) -> None:
        setup = Setup.of(**settings)
        self._height = height
        self._open = contextlib.ExitStack()
        server = self._open.enter_context(serving(0))
        try:
            self._address = url_of(server)
            self.page = Page(server, setup, Path(folder), driver)
        except BaseException:
            self._open.close()
            raise
        self._thread = threading.Thread(target=self.page.run, daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the drive and close the page; may be called twice."""
        self.page.stop()
        self._thread.join()
        self._open.close()

    def _repr_html_(self) -> str:
        return f'<iframe src="{self._address}" width="100%" height="{self._height}" style="border: 0"></iframe>'
