"""One of two halves of a picture: side and front view, and a bar for what is known about every parameter."""

from __future__ import annotations

from jawenv.rendering import palette
from jawenv.rendering.camera import front_camera, side_camera
from jawenv.rendering.canvas import Box, Canvas
from jawenv.rendering.legends import draw_colour_legend
from jawenv.rendering.muscles import split_name, symbol
from jawenv.rendering.palette import ACCENT, FAINT_INK, GRID, INK, SOFT_INK, TRACK
from jawenv.rendering.posterior import SD_LINES, draw_sd
from jawenv.rendering.posterior_layout import SdScale
from jawenv.rendering.scene import Scene
from jawenv.rendering.skull import draw_front_background, draw_side_background
from jawenv.rendering.views import draw_front, draw_side

_SIDE: Box = (10, 58, 306, 360)
_FRONT: Box = (324, 58, 306, 360)
_KNOWLEDGE: Box = (10, 426, 620, 244)
_FOOTER_Y = 696.0
_NAMES = 128.0  # room of the muscles' names


def draw_half(canvas: Canvas, shift: float, scene: Scene, known_sd: float) -> None:
    """Draw a scene in the half that begins ``shift`` design units from the left; ``known_sd`` counts as known."""
    side, front, knowledge = (_moved(card, shift) for card in (_SIDE, _FRONT, _KNOWLEDGE))
    for card in (side, front, knowledge):
        canvas.rect(card, palette.CARD, radius=10, border=palette.BORDER)
    _draw_heading(canvas, shift, scene, known_sd)
    for card, words in ((side, "from the right"), (front, "from the front")):
        canvas.text(words, (card[0] + 14, card[1] + 18), 11.5, SOFT_INK)
    view = _view(side)
    draw_side_background(canvas, side_camera(view, scene.planar), view)
    draw_side(canvas, side_camera(view, scene.planar), view, scene)
    view = _view(front)
    draw_front_background(canvas, front_camera(view), view)
    draw_front(canvas, front_camera(view), view, scene)
    for letter, x in (("R", front[0] + 16), ("L", front[0] + front[2] - 16)):
        canvas.text(letter, (x, front[1] + 200), 13, FAINT_INK, bold=True, anchor="centre")
    _draw_knowledge(canvas, knowledge, scene, known_sd)


def draw_footer(canvas: Canvas, scene: Scene) -> None:
    """Draw the legend of the colours, and the time."""
    draw_colour_legend(canvas, (18, _FOOTER_Y - 4), 400.0)
    left, right = 560.0, 1180.0
    share = min(max(scene.time_s / scene.episode_s, 0.0), 1.0)
    canvas.text("Time", (left - 52, _FOOTER_Y), 13, SOFT_INK)
    canvas.rect((left, _FOOTER_Y - 4, right - left, 8), palette.mix(TRACK, FAINT_INK, 0.25), radius=4)
    canvas.rect((left, _FOOTER_Y - 4, max(share * (right - left), 8), 8), ACCENT, radius=4)
    canvas.text(f"{scene.time_s:.1f} s", (1262, _FOOTER_Y), 17, INK, bold=True, anchor="right")


def _draw_heading(canvas: Canvas, shift: float, scene: Scene, known_sd: float) -> None:
    known, all_of_them = int((scene.belief_sd <= known_sd).sum()), len(scene.belief_sd)
    worst = float(scene.belief_sd.max())
    words = f"knows {known} of {all_of_them} to {100 * known_sd:g} %"
    ink = palette.mix(palette.knowledge(worst), INK, 0.45)
    used = canvas.text(words, (shift + 626, 32), 19, ink, bold=True, anchor="right")
    canvas.text(scene.title, (shift + 16, 32), 22, INK, bold=True, fit=590 - used)


def _draw_knowledge(canvas: Canvas, card: Box, scene: Scene, known_sd: float) -> None:
    """One row per muscle, with a bar for each of its two parameters."""
    x, y, width, height = card
    index = {name: i for i, name in enumerate(scene.parameter_names)}
    worst = float(scene.prior_sd.max())
    column = (width - _NAMES - 16) / 2
    scales = [SdScale(x + _NAMES + k * column + 24, column - 72) for k in (0, 1)]
    top, bottom = y + 34, y + height - 8
    row = (bottom - top) / len(scene.muscles)
    canvas.text("sd of", (x + 16, y + 18), 12, INK, bold=True)
    for parameter, scale in zip(("log_F_o", "log_b"), scales, strict=True):
        for sd in SD_LINES:
            place = scale.x(sd, worst)
            canvas.line([(place, top - 4), (place, bottom)], palette.mix(GRID, FAINT_INK, 0.22), 0.8)
            canvas.text(f"{100 * sd:.0f} %", (place, y + 18), 10.5, SOFT_INK, anchor="centre")
        symbol(canvas, parameter, (scale.left, y + 18), 12.5, INK)
        for number, muscle in enumerate(scene.muscles):
            sd = float(scene.belief_sd[index[f"{parameter}/{muscle}"]])
            draw_sd(canvas, scale, sd, worst, top + (number + 0.5) * row, bold=sd <= known_sd)
    for number, muscle in enumerate(scene.muscles):
        kind, side = split_name(muscle)
        words = f"{kind.replace('_', ' ')} {side[:1].upper()}".strip().capitalize() if kind else f"{side} side"
        words = words[:-1] + words[-1].upper() if kind and side else words
        canvas.text(words, (x + 16, top + (number + 0.5) * row), 11.5, INK, fit=_NAMES - 10)


def _moved(card: Box, shift: float) -> Box:
    return (card[0] + shift, *card[1:])


def _view(card: Box) -> Box:
    """The part of a card that belongs to the picture of the jaw."""
    x, y, width, height = card
    return (x + 2, y + 32, width - 4, height - 40)
