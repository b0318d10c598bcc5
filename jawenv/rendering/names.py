"""Names of the muscles beside the side view, with thin leaders to their lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jawenv.rendering import palette
from jawenv.rendering.camera import Camera
from jawenv.rendering.canvas import Box, Canvas
from jawenv.rendering.muscles import layer_of, side_of, split_name
from jawenv.rendering.scene import Scene

_SHORT = {"anterior": "ant.", "posterior": "post.", "medial": "med."}
_SIZE = 11.5
_LINE = 13.5
_ABOVE = (0.105, 0.195)  # heights of the names of high muscles, as shares of the view
_BELOW = (0.665, 0.96)  # between these stand the names of the others
_FEW_BELOW = (0.79, 0.92)


@dataclass
class _Name:
    """A muscle's name: its words, the places on its lines that leaders point at, and its rank among the names."""

    words: list[str]
    targets: list[tuple[float, float]]
    rank: float


def draw_names(canvas: Canvas, camera: Camera, scene: Scene, box: Box) -> None:
    """Name the muscles of the near side in the free space behind the jaw."""
    high: dict[str, _Name] = {}
    low: dict[str, _Name] = {}
    left, bottom = box[0] + 16, box[1] + box[3]
    for i, name in enumerate(scene.muscle_names):
        if side_of(scene, i) == "left":
            continue
        origin, insertion = scene.muscle_origin_m[i], scene.muscle_insertion_m[i]
        closed = (insertion - scene.contact_m) @ scene.rotation
        names = high if layer_of(scene, i) == "high" else low
        target = camera.project(1000 * (origin + (insertion - origin) * (0.2 if names is high else 0.97)))
        # Ranked in the closed jaw, so that no names change places while it moves; leaders then hardly cross.
        x, y = camera.project(1000 * closed)
        rank = -camera.project(1000 * origin)[0] if names is high else (x - left) / (bottom - y)
        label = names.setdefault(name, _Name(_words(name), [], float(rank)))
        label.targets.append((float(target[0]), float(target[1])))
    low_shares = np.linspace(*_BELOW, len(low)) if len(low) > 2 else np.array(_FEW_BELOW)[: len(low)]
    for shares, names in ((_ABOVE, high), (low_shares, low)):
        ranked = sorted(names.values(), key=lambda name: name.rank)
        _draw_column(canvas, (left, box[1]), [share * box[3] for share in shares[: len(ranked)]], ranked)


def _draw_column(canvas: Canvas, corner: tuple[float, float], heights: list[float], names: list[_Name]) -> None:
    """Set names below each other and draw a leader to each of their lines, clear of the other names."""
    rows = []
    for height, name in zip(heights, names, strict=False):
        for line, word in enumerate(name.words):
            y = corner[1] + height + _LINE * (line - (len(name.words) - 1) / 2)
            rows.append((name, line, y, canvas.text(word, (corner[0], y), _SIZE, palette.SOFT_INK)))
    edge = corner[0] + max((row[3] for row in rows), default=0.0) + 5
    for name, line, y, width in rows:
        if line == 0:
            for target in name.targets:
                points = [(corner[0] + width + 4, y), (max(edge, corner[0] + width + 5), y), target]
                canvas.line(points, palette.SOFT_INK, 0.8)


def _words(name: str) -> list[str]:
    if name in ("left", "right"):
        return [f"{name} side's", "muscles"]
    words = split_name(name)[0].split("_")
    return words if len(words) < 3 else [" ".join(_SHORT.get(word, word) for word in words[:-1]), words[-1]]
