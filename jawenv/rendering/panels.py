"""The lower row: comfort, the motion so far over the time of the whole episode, and the figures of the episode."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jawenv.rendering import palette
from jawenv.rendering.canvas import Box, Canvas
from jawenv.rendering.muscles import split_name, symbol
from jawenv.rendering.palette import ACCENT, ALARM, CARD, FAINT_INK, GRID, INK, SIDE_TRACE, SOFT_INK, SWING_TRACE, TRACK
from jawenv.rendering.scene import Moment, Scene

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
    identified = int((scene.belief_sd <= _IDENTIFIED_SD).sum())
    low = middle + 12
    _figure(canvas, (lefts[0], low), "Within 10 %", f"{identified}", f"of {len(scene.belief_sd)}", column)
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


@dataclass(frozen=True)
class _Axes:
    """Edges of the plot in design units; the scales of time and of length."""

    left: float
    right: float
    top: float
    bottom: float
    end_s: float
    low: float
    high: float
    step: float

    def x(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        """Places of times; those after the end of the episode stay at the edge."""
        return self.left + np.clip(time / self.end_s, 0, 1) * (self.right - self.left)

    def y(self, length: float) -> float:
        """Place of a length, mm; what is off the scale stays at the edge."""
        share = min(max((length - self.low) / (self.high - self.low), 0.0), 1.0)
        return self.bottom - share * (self.bottom - self.top)


def draw_trace(canvas: Canvas, box: Box, scene: Scene, trace: list[Moment]) -> None:
    """Draw opening and excursions so far, and the limits of the opening.

    Args:
        canvas: where to draw.
        box: the card.
        scene: the moment, for its limits and the length of the episode.
        trace: the episode so far, at least one moment.
    """
    points = np.array(trace)
    axes = _axes(box, scene, points)
    _draw_grid(canvas, axes, scene)
    curves = [_curve(axes, points, column) for column in (1, 2, 3)]
    if len(curves[0]) > 1:
        zero = axes.y(0.0)
        area = np.vstack([curves[0], [[curves[0][-1, 0], zero], [curves[0][0, 0], zero]]])
        canvas.polygon(area, palette.mix(ACCENT, CARD, 0.86))
    for limit, colour in zip(scene.opening_limits_mm.tolist(), (INK, ALARM), strict=True):
        canvas.dashes((axes.left, axes.y(limit)), (axes.right, axes.y(limit)), colour)
    shown = _shown(scene)
    for curve, colour in ((curves[2], SWING_TRACE), (curves[1], SIDE_TRACE)):
        if colour in shown and len(curve) > 1:
            canvas.line(curve, colour, 1.5)
    if len(curves[0]) > 1:
        canvas.line(curves[0], ACCENT, 2.2)
    latest = (float(curves[0][-1, 0]), float(curves[0][-1, 1]))
    canvas.circle(latest, 5.0, CARD)
    canvas.circle(latest, 3.6, ACCENT)


def draw_trace_legend(canvas: Canvas, box: Box, scene: Scene) -> None:
    """Name the curves in the card's heading."""
    right, y = box[0] + box[2] - 16, box[1] + 20.5
    for colour, name in reversed(_shown(scene).items()):
        right -= canvas.text(name, (right, y), 11, SOFT_INK, anchor="right") + 5
        canvas.line([(right - 16, y), (right, y)], colour, 2.4)
        right -= 16 + 11


def _shown(scene: Scene) -> dict[palette.Colour, str]:
    """Colours and names of the curves: a hinge has no excursions, a planar jaw none to the side."""
    names = {ACCENT: "opening"}
    if scene.slides:
        names |= {} if scene.planar else {SIDE_TRACE: "to the left"}
        names |= {SWING_TRACE: "forward"}
    return names


def _axes(box: Box, scene: Scene, points: NDArray[np.float64]) -> _Axes:
    """Scales that stay as they are for the whole episode unless the jaw leaves its limits."""
    x, y, width, height = box
    swing = float(scene.excursion_soft_mm.max()) if len(_shown(scene)) > 1 else 0.0
    lowest = min(float(points[:, 1:].min()), -swing, 0.0)
    highest = max(float(points[:, 1:].max()), float(scene.opening_limits_mm[1]), 8.0)
    step = _nice_step(highest - lowest, 6)
    low, high = step * np.floor(lowest / step), step * np.ceil(1.02 * highest / step)
    return _Axes(x + 44, x + width - 40, y + 42, y + height - 28, scene.episode_s, float(low), float(high), step)


def _draw_grid(canvas: Canvas, axes: _Axes, scene: Scene) -> None:
    for level in np.arange(axes.low, axes.high + 1e-9, axes.step):
        position = axes.y(level)
        canvas.line(
            [(axes.left, position), (axes.right, position)], GRID if abs(level) > 1e-9 else palette.FAINT_INK, 1.0
        )
        canvas.text(f"{level:.0f}".replace("-", "−"), (axes.left - 8, position), 10.5, SOFT_INK, anchor="right")
    soft, hard = scene.opening_limits_mm.tolist()
    canvas.text("soft", (axes.right + 6, max(axes.y(soft), axes.y(hard) + 11)), 10, SOFT_INK)
    canvas.text("hard", (axes.right + 6, axes.y(hard)), 10, ALARM)
    end = axes.end_s * (1 + 1e-9)
    interval = _nice_step(axes.end_s, 6)
    times = np.arange(0.0, end, interval)
    for time, position in zip(times.tolist(), axes.x(times).tolist(), strict=True):
        label = f"{time:g} s" if time + interval > end else f"{time:g}"
        canvas.text(label, (position, axes.bottom + 13), 10.5, SOFT_INK, anchor="centre")


def _curve(axes: _Axes, points: NDArray[np.float64], column: int) -> NDArray[np.float64]:
    """One curve (N, 2); one point per half unit is all that can be seen, however long the episode."""
    px = axes.x(points[:, 0])
    chosen = np.append(np.flatnonzero(np.diff(np.floor(2 * px))), len(px) - 1)
    return np.column_stack([px[chosen], [axes.y(value) for value in points[chosen, column].tolist()]])


def _nice_step(span: float, pieces: int) -> float:
    """Smallest of 1, 2, 5, 10, ... that cuts `span` into at most `pieces`."""
    power = 10.0 ** np.floor(np.log10(span / pieces))
    return float(next(power * step for step in (1, 2, 5, 10, 20) if span / (power * step) <= pieces))
