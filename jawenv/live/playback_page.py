"""The page of a recording: the same view, with a time that runs, stands or is chosen."""

from __future__ import annotations

import time
from typing import Any

from jawenv.live.playback import Playback
from jawenv.live.view import View


class PlaybackPage:
    """Shows a recording to all browsers, again and again.

    Args:
        server: a ``viser.ViserServer``.
        playback: the recording.
    """

    def __init__(self, server: Any, playback: Playback) -> None:
        self._playback, self._index, self._paused = playback, 0, False
        self._stopped = False
        self._view = View(server, playback.shown(0))
        last = (len(playback) - 1) * playback.period_s
        self._time = self._view.gui.add_slider("Time, s", 0.0, max(last, 0.01), 0.01, 0.0)
        self._time.on_update(self._jump)
        self._view.gui.add_button("Pause or go on").on_click(lambda _: self._pause())
        self._view.show(playback.shown(0))

    def run(self) -> None:
        """Play in real time until ``stop``."""
        while not self._stopped:
            begun = time.perf_counter()
            self.step()
            time.sleep(max(0.0, self._playback.period_s - (time.perf_counter() - begun)))

    def stop(self) -> None:
        """End ``run``, from any thread or a signal's handler."""
        self._stopped = True

    def step(self) -> None:
        """Show the next moment; the first one follows the last."""
        if not self._paused:
            self._index = (self._index + 1) % len(self._playback)
            self._time.value = round(self._index * self._playback.period_s, 2)
        self._view.show(self._playback.shown(self._index), "a recording; tensions are those of the belief")

    def _pause(self) -> None:
        self._paused = not self._paused

    def _jump(self, event: Any) -> None:
        """Show the chosen time, and stand there."""
        if event.client is not None:
            self._paused = True
            self._index = min(round(self._time.value / self._playback.period_s), len(self._playback) - 1)
