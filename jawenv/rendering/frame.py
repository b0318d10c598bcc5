"""One whole picture: where everything stands, what is drawn once and what anew for every scene."""

from __future__ import annotations

from jawenv.rendering import palette
from jawenv.rendering.camera import front_camera, side_camera
from jawenv.rendering.canvas import Box, Canvas
from jawenv.rendering.muscles import draw_colour_legend, draw_width_legend
from jawenv.rendering.palette import FAINT_INK, INK, SOFT_INK
from jawenv.rendering.panels import draw_comfort, draw_figures, draw_trace, draw_trace_legend
from jawenv.rendering.posterior import draw_posterior, draw_posterior_background
from jawenv.rendering.scene import Moment, Scene
from jawenv.rendering.views import draw_front, draw_front_background, draw_side, draw_side_background

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

    def draw(self, scene: Scene, trace: list[Moment]) -> Canvas:
        """Draw one scene; the canvas is reused by the next call."""
        canvas = self._prepare(scene)
        canvas.text(scene.title, (18, 30), 19, INK, bold=True, fit=1040)
        draw_side(canvas, side_camera(_view(_SIDE), scene.planar), _view(_SIDE), scene)
        draw_front(canvas, front_camera(_view(_FRONT)), _view(_FRONT), scene)
        draw_posterior(canvas, _POSTERIOR, scene)
        draw_comfort(canvas, _COMFORT, scene)
        draw_trace(canvas, _TRACE, scene, trace)
        draw_figures(canvas, _FIGURES, scene)
        return canvas

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


def _legend(card: Box) -> tuple[float, float]:
    """Place where the legend below the picture of the jaw begins."""
    return card[0] + 16, card[1] + card[3] - 24


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
    draw_colour_legend(canvas, _legend(_SIDE), _SIDE[0] + _SIDE[2] - 24)
    draw_width_legend(canvas, _legend(_FRONT))
    for words, x in (("R", _FRONT[0] + 18), ("L", _FRONT[0] + _FRONT[2] - 18)):
        canvas.text(words, (x, _FRONT[1] + 250), 13, FAINT_INK, bold=True, anchor="centre")
