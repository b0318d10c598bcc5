"""The command ``jawenv live``."""

from __future__ import annotations

import signal
import webbrowser
from pathlib import Path
from typing import Any, Protocol

from jawenv.live.server import serving, url_of
from jawenv.live.setup import Setup
from jawenv.playing.policies.card import policy_folder, policy_names
from jawenv.playing.policies.plain import load_plain


class _Page(Protocol):
    def run(self) -> None: ...

    def stop(self) -> None: ...


def drive(
    setup: Setup,
    driver: str,
    port: int,
    folder: Path,
    open_browser: bool,
) -> None:
    """Show a page on which a patient is driven, until Ctrl-C.

    Args:
        setup: whom, and how.
        driver: who drives at first; an exported policy by its folder.
        port: of the page.
        folder: where drives are saved.
        open_browser: whether to open a browser.

    Raises:
        InputError: a setting is refused, or the port is taken.
        MissingPackageError: viser is not installed.
    """
    from jawenv.live.page import Page

    exported = None if driver in policy_names() else policy_folder(driver)
    agents = {} if exported is None else {driver: load_plain(exported, setup.world.env_id)}
    with serving(port) as server:
        _show(Page(server, setup, folder, driver, agents), server, open_browser)


def play_back(path: Path, port: int, open_browser: bool) -> None:
    """Show a recording on a page, until Ctrl-C.

    Raises:
        InputError: the file cannot be read or is damaged, or the port is taken.
        MissingPackageError: viser is not installed.
    """
    from jawenv.live.playback import Playback
    from jawenv.live.playback_page import PlaybackPage
    from jawenv.recordings.files import load_record

    playback = Playback(load_record(path), path.stem)
    with serving(port) as server:
        _show(PlaybackPage(server, playback), server, open_browser)


def _show(page: _Page, server: Any, open_browser: bool) -> None:
    url = url_of(server)
    before = signal.signal(signal.SIGTERM, lambda number, frame: page.stop())  # what was driven is saved
    try:
        print(f"the jaw is at {url} on this machine; Ctrl-C ends it", flush=True)
        if open_browser:
            webbrowser.open(url)
        page.run()
    except KeyboardInterrupt:
        page.stop()
    finally:
        signal.signal(signal.SIGTERM, before)
