"""The view of a moment in all browsers: the jaw, the belief about it, comfort and progress."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from jawenv.live import panels
from jawenv.live.jaw3d import FIRST_POSITION, Jaw3D
from jawenv.live.look import DARK_DIGIT, SCRIPTS, STYLE
from jawenv.live.session import Shown
from jawenv.live.stiffness import stiffness_colours
from jawenv.rendering.muscles import muscle_colours

_NARROW = 0.65  # width over height of the picture: 0.6 of 480 by 800, 0.69 between the panels of 1,400 by 900
_REDRAW_EVERY_S = 0.15  # for sizes and colours; the motion is sent with every step
_PANEL_PX = 390
_HOW_SURE, _HOW_STIFF = "how sure", "how stiff"
_THEME = {"show_logo": False, "show_share_button": False}
_BRAND = {False: (24, 92, 138), True: (86, 160, 211)}  # on a light, on a dark page


class View:
    """The part of a page that shows moments.

    Args:
        server: a ``viser.ViserServer``.
        first: the first moment.

    Attributes:
        gui: of the server, for what a page adds.
        below_status: where among the controls stands what is most urgent.
    """

    def __init__(self, server: Any, first: Shown) -> None:
        self._server, self.gui = server, server.gui
        self._redrawn_at = 0.0
        self._jaw = Jaw3D(server, first.scene)
        self.gui.configure_theme(**_THEME, brand_color=_BRAND[False])
        for label, dark, modifier in (("Dark page", True, None), ("Light page", False, "shift")):
            command = self.gui.add_command(label, hotkey=str(DARK_DIGIT), modifier=modifier)
            command.on_trigger(lambda event, dark=dark: _set_scheme(event.client, dark))
        self.gui.set_panel_label("jawenv live")
        self.gui.main_panel.dock_right()
        self.gui.main_panel.set_width(_PANEL_PX)
        self._status, self._strip, self._beside = (self.gui.add_html("") for _ in range(3))
        self.below_status: float = self._strip.order + 0.5
        self.gui.add_html(STYLE + SCRIPTS)
        panel = self.gui.add_panel()
        with panel.add_tab("Knowledge"):
            self._posterior, self._comfort = self.gui.add_html(""), self.gui.add_html("")
            self._colour = self.gui.add_button_group("Colour", (_HOW_SURE, _HOW_STIFF))
            self._legend = self.gui.add_html("")
        panel.dock_left()
        panel.set_width(_PANEL_PX)
        panel.expand()
        server.on_client_connect(_fit)

    def on_colour(self, callback: Any) -> None:
        """Call viser's ``callback`` when a browser chooses other colours."""
        self._colour.on_click(callback)

    @property
    def watched(self) -> bool:
        """Whether a browser shows the page."""
        return bool(self._server.get_clients())

    def show(self, shown: Shown, remark: str = "") -> None:
        """Show a moment, with a remark below the figures."""
        by_stiffness = self._colour.value == _HOW_STIFF
        now = time.monotonic()
        redraw = shown.ended or now - self._redrawn_at >= _REDRAW_EVERY_S
        if redraw:
            self._redrawn_at = now
        with self._server.atomic():
            self._jaw.colours = stiffness_colours if by_stiffness else muscle_colours
            self._jaw.show(shown.scene, redraw)
            self._legend.content = panels.legend_html(shown.scene, by_stiffness)
            self._posterior.content = panels.posterior_html(shown.scene)
            self._strip.content = panels.strip_html(shown.scene)
            self._comfort.content = panels.comfort_html(shown.scene)
            self._status.content = panels.status_html(shown, remark)

    def show_ghost(self, shown: Shown | None) -> None:
        """Show where another driver has the jaw of the same patient, and how far it has come; None for nobody."""
        self._jaw.show_ghost(None if shown is None else shown.scene)
        self._beside.content = "" if shown is None else panels.ghost_html(shown)

    def say(self, shown: Shown, remark: str) -> None:
        """Change only the figures and the remark."""
        self._status.content = panels.status_html(shown, remark)

    def renew(self, first: Shown) -> None:
        """Another patient or model: another jaw."""
        self._jaw.remove()
        self._jaw = Jaw3D(self._server, first.scene)


def _set_scheme(client: Any, dark: bool) -> None:
    """Make the page of one browser dark or light."""
    client.gui.configure_theme(dark_mode=dark, **_THEME, brand_color=_BRAND[dark])


def _fit(client: Any) -> None:
    """Put the jaw above the sheet of controls on a narrow page, as often as viser begins as on a wide one."""

    def look(camera: Any) -> None:
        if camera.aspect < _NARROW and np.allclose(camera.position, FIRST_POSITION, atol=0.01):
            camera.position = (6.2, -5.6, -1.0)
            camera.look_at = (0.45, 0.0, -1.4)

    look(client.camera)
    client.camera.on_update(look)
