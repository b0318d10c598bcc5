"""Antialiased drawing in design units, whatever the size of the picture.

Shapes are drawn at twice the size and scaled down once; text is set afterwards at its final size, so it stays
crisp. Nothing here touches the display: a picture can be drawn where there is none.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
import pygame
import pygame.gfxdraw
from numpy.typing import NDArray

from jawenv.rendering.palette import INK, PAGE, Colour

DESIGN_SIZE = (1280, 720)
SUPERSAMPLE = 2
_FAMILIES = ("inter", "helveticaneue", "liberationsans", "notosans", "segoeui", "arial", "dejavusans")
_CACHED_TEXTS = 2000

Points = NDArray[np.float64] | Sequence[tuple[float, float]]
Box = tuple[float, float, float, float]


class Canvas:
    """One picture. Positions and lengths are design units, scaled to fit and centred."""

    def __init__(self, size: tuple[int, int], design: tuple[int, int] = DESIGN_SIZE) -> None:
        """Make an empty picture of `size` pixels, `design` units wide and high."""
        pygame.font.init()
        self.size = size
        self._scale = min(size[0] / design[0], size[1] / design[1])
        self._shift = np.array([(size[i] - self._scale * design[i]) / 2 for i in (0, 1)])
        self._zoom = self._scale * SUPERSAMPLE
        self._offset = self._shift * SUPERSAMPLE
        self._surface = pygame.Surface((size[0] * SUPERSAMPLE, size[1] * SUPERSAMPLE), depth=32)
        self._surface.fill(PAGE)
        self._result = pygame.Surface(size, depth=32)
        self._texts: list[tuple[pygame.Surface, tuple[float, float]]] = []
        self._fonts: dict[tuple[float, bool], pygame.font.Font] = {}
        self._set: dict[tuple[str, float, bool, Colour], pygame.Surface] = {}
        self._background: tuple[pygame.Surface, int] | None = None

    def keep_as_background(self) -> None:
        """Remember what is drawn so far; `restore` goes back to it."""
        self._background = (self._surface.copy(), len(self._texts))

    def restore(self) -> None:
        """Remove everything drawn since `keep_as_background`."""
        assert self._background is not None
        surface, texts = self._background
        self._surface.blit(surface, (0, 0))
        del self._texts[texts:]

    def finish(self) -> pygame.Surface:
        """Return the picture at its final size; the surface is reused by the next call."""
        pygame.transform.smoothscale(self._surface, self.size, self._result)
        self._result.blits(self._texts)
        return self._result

    def pixels(self) -> NDArray[np.uint8]:
        """Return the picture at its final size as a new array (height, width, 3)."""
        flat = np.frombuffer(pygame.image.tobytes(self.finish(), "RGB"), dtype=np.uint8)
        return flat.reshape(self.size[1], self.size[0], 3).copy()

    def clip(self, box: Box | None) -> None:
        """Draw shapes inside `box` only; None lifts the limit."""
        self._surface.set_clip(None if box is None else self._rect(box))

    def rect(self, box: Box, colour: Colour, radius: float = 0.0, border: Colour | None = None) -> None:
        """Filled rectangle with rounded corners and, if wanted, a border of one unit."""
        rect, corner = self._rect(box), round(radius * self._zoom)
        pygame.draw.rect(self._surface, colour, rect, border_radius=corner)
        if border is not None:
            pygame.draw.rect(self._surface, border, rect, max(1, round(self._zoom)), border_radius=corner)

    def circle(self, centre: tuple[float, float], radius: float, colour: Colour) -> None:
        """Filled circle."""
        x, y = self._points([centre])[0]
        pygame.draw.circle(self._surface, colour, (x, y), radius * self._zoom)

    def line(self, points: Points, colour: Colour, width: float = 1.0) -> None:
        """Open polyline with round joints and ends."""
        pixels = self._points(points)
        half = max(0.5, width * self._zoom / 2)
        for (x0, y0), (x1, y1) in zip(pixels, pixels[1:], strict=False):
            length = float(np.hypot(x1 - x0, y1 - y0))
            if length == 0:
                continue
            nx, ny = -(y1 - y0) / length * half, (x1 - x0) / length * half
            corners = [(x0 + nx, y0 + ny), (x1 + nx, y1 + ny), (x1 - nx, y1 - ny), (x0 - nx, y0 - ny)]
            pygame.draw.polygon(self._surface, colour, corners)
        if half > 1.2:
            for point in pixels:
                pygame.draw.circle(self._surface, colour, point, half)

    def dashes(self, start: tuple[float, float], end: tuple[float, float], colour: Colour) -> None:
        """Dashed line."""
        a, b = np.array(start), np.array(end)
        count = max(1, int(np.hypot(*(b - a)) / 4))
        for i in range(0, count, 2):
            piece = [a + (b - a) * share for share in (i / count, (i + 1) / count)]
            self.line(np.stack(piece), colour)

    def polygon(self, points: Points, colour: Colour, alpha: int = 255) -> None:
        """Filled polygon; `alpha` below 255 lets what lies beneath shine through."""
        pixels = self._points(points)
        if alpha == 255:
            pygame.draw.polygon(self._surface, colour, pixels)
        else:
            pygame.gfxdraw.filled_polygon(self._surface, pixels, (*colour, alpha))

    def polygons(self, quads: NDArray[np.float64], colours: Sequence[Colour]) -> None:
        """Many filled polygons: `quads` (N, K, 2) in the order of painting."""
        draw, surface = pygame.draw.polygon, self._surface
        pixels = np.rint(quads * self._zoom + self._offset).astype(np.int32)
        for colour, quad in zip(colours, pixels.tolist(), strict=True):
            draw(surface, colour, quad)

    def segments(self, ends: NDArray[np.float64], colour: Colour, width: float) -> None:
        """Many straight lines (N, 2, 2) of one colour and width."""
        across = np.stack([ends[:, 0, 1] - ends[:, 1, 1], ends[:, 1, 0] - ends[:, 0, 0]], axis=-1)
        length = np.linalg.norm(across, axis=-1, keepdims=True)
        across *= width / 2 / np.maximum(length, 1e-9)
        start, end = ends[:, 0], ends[:, 1]
        quads = np.stack([start + across, end + across, end - across, start - across], axis=1)
        self.polygons(quads, [colour] * len(quads))

    def text(
        self,
        words: str,
        at: tuple[float, float],
        size: float = 12,
        colour: Colour = INK,
        *,
        bold: bool = False,
        anchor: str = "left",
        fit: float | None = None,
    ) -> float:
        """Set one line of text.

        Args:
            words: the text.
            at: the anchor; its height is the middle of the line.
            size: height of the font.
            colour: colour of the text.
            bold: bold or regular.
            anchor: "left", "centre" or "right" of the line is at `at`.
            fit: largest width; longer text is set smaller, and cut if even 70 % of the size does not fit.

        Returns:
            The width of the text.
        """
        image = self._typeset(words, size, bold, colour)
        room = np.inf if fit is None else fit * self._scale
        if image.get_width() > room:
            size = max(0.7 * size, size * room / image.get_width())
            while words and (image := self._typeset(words, size, bold, colour)).get_width() > room:
                words = words[:-2].rstrip(" …") + "…" if len(words) > 2 else ""
        width = image.get_width() / self._scale
        left = at[0] - {"left": 0.0, "centre": width / 2, "right": width}[anchor]
        x = left * self._scale + self._shift[0]
        y = at[1] * self._scale + self._shift[1] - image.get_height() / 2
        self._texts.append((image, (round(x), round(y))))
        return width

    def _typeset(self, words: str, size: float, bold: bool, colour: Colour) -> pygame.Surface:
        key = (words, size, bold, colour)
        if key not in self._set:
            if len(self._set) > _CACHED_TEXTS:
                self._set.clear()
            self._set[key] = self._font(size, bold).render(words, True, colour)
        return self._set[key]

    def _font(self, size: float, bold: bool) -> pygame.font.Font:
        if (size, bold) not in self._fonts:
            with warnings.catch_warnings():
                # A machine without fontconfig gets pygame's own font, and needs no warning about it.
                warnings.simplefilter("ignore")
                matches = (pygame.font.match_font(name, bold=bold) for name in _FAMILIES)
                path = next(filter(None, matches), None)
            # The letters of pygame's own font are small for their nominal size.
            grow = 1.1 if path else 1.35
            self._fonts[size, bold] = pygame.font.Font(path, max(6, round(size * self._scale * grow)))
        return self._fonts[size, bold]

    def _points(self, points: Points) -> list[tuple[float, float]]:
        array = np.asarray(points, dtype=np.float64) * self._zoom + self._offset
        pixels: list[tuple[float, float]] = array.tolist()
        return pixels

    def _rect(self, box: Box) -> pygame.Rect:
        x, y, width, height = box
        left, top = self._points([(x, y)])[0]
        return pygame.Rect(round(left), round(top), round(width * self._zoom), round(height * self._zoom))
