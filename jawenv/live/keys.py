"""Keys that are held, from the browser to the loop.

viser has hotkeys, which say that a key was pressed and not that it was let go, and its camera moves with the keys that
drive here. So a script of the page catches those keys before the camera does, and hands each press and release to a
hotkey of viser's own: a digit, with shift where the key is let go. It needs no connection besides viser's.
"""

from __future__ import annotations

import json
import threading
from typing import Any

import numpy as np

from jawenv.device.channels import FORE_AFT, HIGHEST, LOWEST, OPENING, ROLL, SIDE
from jawenv.playing.agents import Array

DRIVE_KEYS: dict[str, tuple[str, int, float]] = {
    "KeyW": ("close", OPENING, -0.5),
    "KeyS": ("open", OPENING, 0.5),
    "KeyA": ("to the patient's right", SIDE, -1.5),
    "KeyD": ("to the patient's left", SIDE, 1.5),
    "ArrowUp": ("push forward", FORE_AFT, 1.0),
    "ArrowDown": ("pull back", FORE_AFT, -1.0),
    "ArrowLeft": ("lower the left side", ROLL, -1.5),
    "ArrowRight": ("lower the right side", ROLL, 1.5),
}
"""Code of a key -> what it does, its channel, and how fast it moves the target, 1/s."""

HELP = "<b>S W</b> open, close · <b>A D</b> right, left · <b>↑ ↓</b> push, pull · <b>← →</b> roll"


class Keys:
    """Drive keys that are held, in all browsers together.

    Args:
        server: a ``viser.ViserServer``, which gets the hotkeys.
    """

    def __init__(self, server: Any) -> None:
        self._held: dict[str, set[int]] = {code: set() for code in DRIVE_KEYS}
        self._tapped: set[str] = set()
        self._lock = threading.Lock()
        for number, (code, (words, _, _)) in enumerate(DRIVE_KEYS.items(), start=1):
            press = server.gui.add_command(f"Hold: {words}", hotkey=str(number))
            release = server.gui.add_command(f"Let go: {words}", hotkey=str(number), modifier="shift")
            press.on_trigger(lambda event, code=code: self.press(code, event.client_id))
            release.on_trigger(lambda event, code=code: self.release(code, event.client_id))
        server.on_client_disconnect(lambda client: self.forget(client.client_id))

    @property
    def used(self) -> bool:
        """Whether a key is held, or was pressed since the last ``take``."""
        with self._lock:
            return bool(self._tapped) or any(self._held.values())

    def press(self, code: str, client: int) -> None:
        """A key goes down in a browser."""
        with self._lock:
            self._held[code].add(client)
            self._tapped.add(code)

    def release(self, code: str, client: int) -> None:
        """A key goes up in a browser."""
        with self._lock:
            self._held[code].discard(client)

    def forget(self, client: int) -> None:
        """A browser has left."""
        with self._lock:
            for clients in self._held.values():
                clients.discard(client)

    def take(self) -> set[str]:
        """The keys that are held, or were pressed since the last call."""
        with self._lock:
            down = self._tapped | {code for code, clients in self._held.items() if clients}
            self._tapped = set()
        return down


def moved(targets: Array, down: set[str], seconds: float) -> Array:
    """Targets (4,) after keys were down for so long."""
    after = targets.copy()
    for code in down:
        _, channel, speed = DRIVE_KEYS[code]
        after[channel] += speed * seconds
    lowest: Array = np.array(LOWEST)
    return np.clip(after, lowest, HIGHEST)


_SCRIPT = """
if (!window.jawenvKeys) {
  window.jawenvKeys = true;
  const codes = CODES, held = new Set();
  const tell = (code, up) => {
    const digit = String(codes.indexOf(code) + 1);
    document.documentElement.dispatchEvent(new KeyboardEvent('keydown',
      {key: digit, code: 'Digit' + digit, shiftKey: up, bubbles: true}));
  };
  const writes = (target) => target && target.closest && target.closest('input, textarea, select');
  const on = (event, up) => {
    if (!codes.includes(event.code) || event.ctrlKey || event.metaKey || event.altKey) return;
    if (writes(event.target) && !held.has(event.code)) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    if (up ? held.delete(event.code) : !held.has(event.code) && held.add(event.code)) tell(event.code, up);
  };
  window.addEventListener('keydown', (event) => on(event, false), true);
  window.addEventListener('keyup', (event) => on(event, true), true);
  window.addEventListener('blur', () => { held.forEach((code) => tell(code, true)); held.clear(); });
}
"""


def keys_html() -> str:
    """The help line, and the script."""
    script = _SCRIPT.replace("CODES", json.dumps(list(DRIVE_KEYS)))
    style = "font:12px/1.4 system-ui,sans-serif;color:var(--live-soft);margin:4px 12px"
    return f'<div id="keys" style="{style}">{HELP}{script_html(script)}</div>'


def script_html(script: str) -> str:
    """An image that cannot be loaded, which starts a script where viser's page puts the HTML."""
    words = " ".join(script.split()).replace('"', "&quot;")
    return f'<img alt="" src="data:," hidden onerror="{words}">'
