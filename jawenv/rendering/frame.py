"""One whole picture: where everything stands, what is drawn once and what anew for every scene."""

from __future__ import annotations

import math

import numpy as np
import pygame

from jawenv.rendering import palette
from jawenv.rendering.canvas import Box, Canvas
from jawenv.rendering.muscles import draw_muscle, muscle_width
from jawenv.rendering.palette import FAINT_INK, INK, SOFT_INK
from jawenv.rendering.panels import draw_comfort, draw_figures
from jawenv.rendering.posterior import draw_posterior, draw_posterior_background
from jawenv.rendering.scene import Moment, Scene
from jawenv.rendering.skull import draw_front_background, draw_side_background
from jawenv.rendering.trace import draw_trace, draw_trace_legend
from jawenv.rendering.views import draw_front, draw_side, front_camera, side_camera

_SIDE: Box = (14, 54, 386, 456)
_FRONT: Box = (412, 54, 386, 456)
_POSTERIOR: Box = (810, 54, 456, 456)
_COMFORT: Box = (14, 522, 386, 184)
_TRACE: Box = (412, 522, 386, 184)
_FIGURES: Box = (810, 522, 456, 184)
CARDS = (_SIDE, _FRONT, _POSTERIOR, _COMFORT, _TRACE, _FIGURES)
_LEGEND = 38.0
_HEADING = 34.0


class Frame:
    """Draws scenes of one size; keeps what does not change between two scenes of the same kind."""

    def __init__(self, size: tuple[int, int]) -> None:
        """Make a frame of `size` pixels."""
        self._size = size
        self._canvas: Canvas | None = None
        self._kind: tuple[object, ...] = ()

    def draw(self, scene: Scene, trace: list[Moment]) -> pygame.Surface:
        """Draw one scene; the surface is reused by the next call."""
        canvas = self._prepare(scene)
        canvas.text(scene.title, (18, 30), 19, INK, bold=True, fit=1040)
        draw_side(canvas, side_camera(_view(_SIDE), scene.planar), _view(_SIDE), scene)
        draw_front(canvas, front_camera(_view(_FRONT)), _view(_FRONT), scene)
        draw_posterior(canvas, _POSTERIOR, scene)
        draw_comfort(canvas, _COMFORT, scene)
        draw_trace(canvas, _TRACE, scene, trace)
        draw_figures(canvas, _FIGURES, scene)
        return canvas.finish()

    def _prepare(self, scene: Scene) -> Canvas:
        prior = (scene.prior_mean.tobytes(), scene.prior_sd.tobytes())
        kind = (scene.muscle_names, scene.parameter_names, prior, scene.truth is None, scene.planar, scene.slides)
        if self._canvas is None or kind != self._kind:
            self._canvas, self._kind = Canvas(self._size), kind
            _draw_background(self._canvas, scene)
            self._canvas.keep_as_background()
        self._canvas.restore()
        return self._canvas


def _view(card: Box) -> Box:
    """The part of a card that belongs to the picture of the jaw."""
    x, y, width, height = card
    return (x + 2, y + _HEADING, width - 4, height - _HEADING - _LEGEND)


def _draw_background(canvas: Canvas, scene: Scene) -> None:
    canvas.text("jawenv", (1264, 30), 15, FAINT_INK, bold=True, anchor="right")
    lines = len(scene.muscle_names)
    in_plane = "its muscle stands for both sides" if lines == 1 else "each muscle stands for both sides"
    headings = (
        (_SIDE, "Side view", "midplane" if scene.planar else "seen from the patient's right"),
        (_FRONT, "Front view", in_plane if scene.planar else "facing the patient"),
        (_POSTERIOR, "Posterior", f"of the {len(scene.parameter_names)} muscle parameters"),
        (_COMFORT, "Comfort", "used share of each soft limit"),
        (_TRACE, "Motion", "mm"),
        (_FIGURES, "", ""),
    )
    for card, name, remark in headings:
        canvas.rect(card, palette.CARD, radius=10, border=palette.BORDER)
        used = canvas.text(name, (card[0] + 16, card[1] + 20), 13.5, INK, bold=True)
        canvas.text(remark, (card[0] + 16 + used + 8, card[1] + 20.5), 11, SOFT_INK)
    draw_side_background(canvas, side_camera(_view(_SIDE), scene.planar), _view(_SIDE))
    draw_front_background(canvas, front_camera(_view(_FRONT)), _view(_FRONT))
    draw_posterior_background(canvas, _POSTERIOR, scene)
    draw_trace_legend(canvas, _TRACE, scene)
    _draw_colour_legend(canvas, _SIDE, float(scene.prior_sd.max()))
    _draw_width_legend(canvas, _FRONT)
    for words, x in (("R", _FRONT[0] + 18), ("L", _FRONT[0] + _FRONT[2] - 18)):
        canvas.text(words, (x, _FRONT[1] + 250), 13, FAINT_INK, bold=True, anchor="centre")


def _draw_colour_legend(canvas: Canvas, card: Box, prior_sd: float) -> None:
    x, y = card[0] + 16, card[1] + card[3] - 24
    canvas.text("Muscle colour: sd", (x, y), 10.5, SOFT_INK)
    left, right = x + 112, card[0] + card[2] - 24
    span = math.log(palette.UNKNOWN_SD / palette.KNOWN_SD)
    pieces = 80
    for i in range(pieces):
        sd = palette.UNKNOWN_SD * math.exp(-span * (i + 0.5) / pieces)
        width = (right - left) / pieces
        canvas.rect((left + i * width, y - 5, width + 0.6, 8), palette.knowledge(sd))
    for sd in (0.5, 0.2, 0.1, 0.05, 0.02, 0.01):
        at = left + math.log(palette.UNKNOWN_SD / sd) / span * (right - left)
        canvas.line([(at, y - 5), (at, y + 5)], palette.CARD if 0.01 < sd < 0.5 else palette.BORDER, 1.0)
        canvas.text(f"{100 * sd:.0f} %", (at, y + 12), 10, SOFT_INK, anchor="centre")


def _draw_width_legend(canvas: Canvas, card: Box) -> None:
    x, y = card[0] + 16, card[1] + card[3] - 24
    canvas.text("Muscle width: tension", (x, y), 10.5, SOFT_INK)
    for i, tension in enumerate((1.0, 5.0, 20.0)):
        left = x + 134 + i * 78
        draw_muscle(canvas, np.array([left, y]), np.array([left + 34.0, y]), muscle_width(tension), FAINT_INK)
        canvas.text(f"{tension:g} N", (left + 42, y), 10.5, SOFT_INK)
