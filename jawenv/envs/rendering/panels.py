"""The lower row: comfort, opening over time, and the figures of the episode."""

from __future__ import annotations

import numpy as np

from jawenv.envs.rendering import palette
from jawenv.envs.rendering.canvas import Box, Canvas
from jawenv.envs.rendering.muscles import symbol
from jawenv.envs.rendering.palette import ACCENT, CARD, FAINT_INK, GRID, INK, SOFT_INK, TRACK
from jawenv.envs.rendering.scene import Scene

_IDENTIFIED_SD = 0.10


def draw_comfort(canvas: Canvas, box: Box, scene: Scene) -> None:
    """Draw one bar per limit: used fraction, the soft limit at 1 and the hard limit."""
    x, y, width, height = box
    left, right = x + 122, x + width - 64
    top, bottom = y + 50, y + height - 10
    if not scene.comfort:
        return
    end = 1.08 * max(scene.comfort_hard[name] for name in scene.comfort)

    def place(fraction: float) -> float:
        return left + (right - left) * min(max(fraction / end, 0.0), 1.0)

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
            length = max(place(used) - left, 2 * half)
            canvas.rect((left, middle - half, length, 2 * half), colour, radius=half)
        for rim, paint in ((2.4, CARD), (0.0, palette.ALARM)):
            canvas.line([(place(hard), middle - half - 1), (place(hard), middle + half + 1)], paint, 2 + rim)
        over = used > 1
        ink = palette.mix(colour, INK, 0.25) if over else SOFT_INK
        canvas.text(f"{100 * used:.0f} %", (x + width - 16, middle), 11.5, ink, bold=over, anchor="right")
    canvas.line([(place(1.0), top - 3), (place(1.0), bottom)], INK, 1.0)
    canvas.text("soft", (place(1.0), top - 11), 10, SOFT_INK, anchor="centre")
    nearest = min(scene.comfort_hard[name] for name in scene.comfort)
    canvas.text("hard", (max(place(nearest), place(1.0) + 28), top - 11), 10, palette.ALARM, anchor="centre")


def draw_trace(canvas: Canvas, box: Box, scene: Scene, trace: list[tuple[float, float]]) -> None:
    """Draw the opening so far over the time of the whole episode.

    Args:
        canvas: where to draw.
        box: the card.
        scene: the moment, for its time and the length of the episode.
        trace: (time s, opening mm) so far.
    """
    x, y, width, height = box
    left, right, top, bottom = x + 44, x + width - 26, y + 46, y + height - 30
    points = np.array(trace)
    least, most = min(0.0, float(points[:, 1].min())), max(8.0, float(points[:, 1].max()))
    step = _nice_step(most - least, 4)
    low, high = step * np.floor(least / step), step * np.ceil(1.02 * most / step)
    for level in np.arange(low, high + 1e-9, step):
        at = bottom - (level - low) / (high - low) * (bottom - top)
        canvas.line([(left, at), (right, at)], GRID if level else palette.BORDER, 1.0)
        canvas.text(f"{level:.0f}", (left - 8, at), 10.5, SOFT_INK, anchor="right")
    every = _nice_step(scene.episode_s, 6)
    for time in np.arange(0.0, scene.episode_s * (1 + 1e-9), every):
        last = time + every > scene.episode_s * (1 + 1e-9)
        at = left + time / scene.episode_s * (right - left)
        words = f"{time:g} s" if last else f"{time:g}"
        canvas.text(words, (at, bottom + 14), 10.5, SOFT_INK, anchor="centre")
    px = left + np.clip(points[:, 0] / scene.episode_s, 0, 1) * (right - left)
    py = bottom - (points[:, 1] - low) / (high - low) * (bottom - top)
    # One point per half unit is all that can be seen, however long the episode.
    seen = np.append(np.flatnonzero(np.diff(np.floor(2 * px))), len(px) - 1)
    curve = np.column_stack([px, py])[seen]
    if len(curve) > 1:
        floor = bottom + low / (high - low) * (bottom - top)
        area = np.vstack([curve, [[px[-1], floor], [px[0], floor]]])
        canvas.polygon(area, palette.mix(ACCENT, CARD, 0.86))
        canvas.line(curve, ACCENT, 2.0)
    here = (float(px[-1]), float(py[-1]))
    canvas.circle(here, 5.0, CARD)
    canvas.circle(here, 3.6, ACCENT)


def _nice_step(span: float, pieces: int) -> float:
    """Smallest of 1, 2, 5, 10, ... that cuts `span` into at most `pieces`."""
    power = 10.0 ** np.floor(np.log10(span / pieces))
    return float(next(power * step for step in (1, 2, 5, 10, 20) if span / (power * step) <= pieces))


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
    _figure(canvas, (lefts[2], y + 16), "Opening", f"{scene.opening_mm:.1f}", "mm", column)
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
    kind, _, side = muscle.rpartition("_")
    return f"{kind.replace('_', ' ')} {side[0].upper()}"
