"""The lower row: comfort, and the figures of the episode."""

from __future__ import annotations

import numpy as np

from jawenv.rendering import palette
from jawenv.rendering.canvas import Box, Canvas
from jawenv.rendering.muscles import split_name, symbol
from jawenv.rendering.palette import ACCENT, CARD, FAINT_INK, INK, SOFT_INK, TRACK
from jawenv.rendering.scene import Scene

_IDENTIFIED_SD = 0.10
_SOFT_AT, _HARD_AT = 0.68, 0.93  # places of the limits as shares of a bar


def draw_comfort(canvas: Canvas, box: Box, scene: Scene) -> None:
    """Draw one bar per limit: its used fraction, with the soft limits below each other and so the hard ones."""
    x, y, width, height = box
    left, right = x + 122, x + width - 64
    top, bottom = y + 50, y + height - 10
    if not scene.comfort:
        return

    def place(fraction: float, hard: float) -> float:
        beyond = _HARD_AT - _SOFT_AT
        share = _SOFT_AT * fraction if fraction <= 1 else _SOFT_AT + beyond * (fraction - 1) / (hard - 1)
        return left + (right - left) * min(max(share, 0.0), 1.0)

    row = (bottom - top) / len(scene.comfort)
    for number, (name, used) in enumerate(scene.comfort.items()):
        middle = top + (number + 0.5) * row
        hard = scene.comfort_hard[name]
        colour = palette.comfort(used, hard)
        half = min(4.5, 0.32 * row)
        label = name.replace("_", " ").replace("fore aft", "fore-aft").capitalize()
        canvas.text(label, (x + 16, middle), 11.5, INK, fit=100)
        canvas.rect((left, middle - half, right - left, 2 * half), TRACK, radius=half)
        if used > 0:
            length = max(place(used, hard) - left, 2 * half)
            canvas.rect((left, middle - half, length, 2 * half), colour, radius=half)
        over = used > 1
        ink = palette.mix(colour, INK, 0.25) if over else SOFT_INK
        canvas.text(f"{100 * used:.0f} %", (x + width - 16, middle), 11.5, ink, bold=over, anchor="right")
    for position, name, colour in ((_SOFT_AT, "soft", INK), (_HARD_AT, "hard", palette.ALARM)):
        x = left + position * (right - left)
        canvas.line([(x, top - 3), (x, bottom)], colour, 1.2)
        canvas.text(name, (x, top - 11), 10, SOFT_INK if colour == INK else colour, anchor="centre")


def draw_figures(canvas: Canvas, box: Box, scene: Scene) -> None:
    """Draw time, information, opening, what is identified, the worst parameter and the governor."""
    x, y, width, height = box
    column, middle = (width - 32) / 3, y + height / 2
    lefts = [x + 16 + i * column for i in range(3)]
    share = min(max(scene.time_s / scene.episode_s, 0.0), 1.0)
    _figure(canvas, (lefts[0], y + 16), "Time", f"{scene.time_s:.1f}", f"of {scene.episode_s:g} s", column)
    canvas.rect((lefts[0], y + 76, column - 24, 5), TRACK, radius=2.5)
    canvas.rect((lefts[0], y + 76, max(share * (column - 24), 5), 5), ACCENT, radius=2.5)
    _figure(canvas, (lefts[1], y + 16), "Information", f"{scene.information_nats:.1f}", "nats", column)
    _figure(canvas, (lefts[2], y + 16), "Opening", f"{scene.opening_mm:.1f}".replace("-", "−"), "mm", column)
    known = int((scene.belief_sd <= _IDENTIFIED_SD).sum())
    low = middle + 12
    _figure(canvas, (lefts[0], low), "Known to 10 %", f"{known}", f"of {len(scene.belief_sd)}", column)
    worst = int(np.argmax(scene.belief_sd))
    _figure(canvas, (lefts[1], low), "Least known", f"{100 * scene.belief_sd[worst]:.0f} %", "sd", column)
    parameter, _, muscle = scene.parameter_names[worst].partition("/")
    used = symbol(canvas, parameter, (lefts[1], low + 64), 10.5, SOFT_INK)
    canvas.text(_with_side(muscle), (lefts[1] + used + 5, low + 64), 10.5, SOFT_INK, fit=column - used - 14)
    _draw_governor(canvas, (lefts[2], low), scene.governor, column)


def _figure(canvas: Canvas, at: tuple[float, float], name: str, value: str, unit: str, width: float) -> None:
    canvas.text(name, (at[0], at[1] + 8), 11.5, SOFT_INK, fit=width - 8)
    used = canvas.text(value, (at[0], at[1] + 36), 25, INK, bold=True, fit=width - 40)
    canvas.text(unit, (at[0] + used + 5, at[1] + 40), 12, SOFT_INK)


def _draw_governor(canvas: Canvas, at: tuple[float, float], share: float, width: float) -> None:
    """Lamp: dark while the device obeys, amber while the governor holds it back."""
    canvas.text("Governor", (at[0], at[1] + 8), 11.5, SOFT_INK)
    active = share > 0
    colour = palette.mix(palette.WARN, palette.ALARM, share) if active else palette.mix(FAINT_INK, CARD, 0.45)
    lamp = (at[0] + 11, at[1] + 36)
    if active:
        canvas.circle(lamp, 14, palette.mix(colour, CARD, 0.72))
    canvas.circle(lamp, 9, palette.mix(colour, INK, 0.25))
    canvas.circle(lamp, 7.6, colour)
    canvas.circle((lamp[0] - 2.4, lamp[1] - 2.6), 2.2, palette.mix(colour, CARD, 0.6))
    canvas.text("acting" if active else "idle", (at[0] + 30, at[1] + 36), 16, INK, bold=True)
    canvas.text(f"{100 * share:.0f} % of the last step", (at[0], at[1] + 64), 10.5, SOFT_INK, fit=width - 4)


def _with_side(muscle: str) -> str:
    kind, side = split_name(muscle)
    return f"{kind.replace('_', ' ')} {side[:1].upper()}".strip() if kind else f"{side} side"
