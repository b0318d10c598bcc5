"""Pictures of N worlds, each with its own motion over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from jawenv.envs.shown_world import build_scene, moment_of
from jawenv.envs.simulation import Simulation

__all__ = ["WorldPictures", "picture_size"]

# The most worlds that are drawn at a size, and its width and height in pixels; more worlds get the last.
_SIZES = ((1, (1280, 720)), (4, (640, 360)))
_SMALLEST = (480, 270)


def picture_size(num_worlds: int) -> tuple[int, int]:
    """Width and height in pixels of one world's picture: smaller where there are more, since all are drawn."""
    return next((size for most, size in _SIZES if num_worlds <= most), _SMALLEST)


class WorldPictures:
    """Draws each of N worlds; a world's picture equals that of the single environment, but for its size.

    Args:
        simulation: The worlds.
        fps: Control steps per second.
    """

    def __init__(self, simulation: Simulation, fps: float) -> None:
        """Make a renderer for each world; pygame is imported when the first is drawn."""
        from jawenv.rendering.renderer import Renderer

        number = len(simulation.worlds)
        self._simulation = simulation
        self._renderers = [Renderer("rgb_array", fps, picture_size(number)) for _ in range(number)]

    def note(self) -> None:
        """Keep the moment of each world for its curves; one that has begun anew forgets its past episode."""
        for i, renderer in enumerate(self._renderers):
            renderer.note(moment_of(self._simulation, i))

    def draw(self, titles: Sequence[str | None]) -> tuple[NDArray[np.uint8], ...]:
        """A new frame (height, width, 3) of each world.

        Args:
            titles: what stands above each; model, cohort and control mode where it is None.
        """
        scenes = (build_scene(self._simulation, title, i) for i, title in enumerate(titles))
        return tuple(renderer.draw(scene) for renderer, scene in zip(self._renderers, scenes, strict=True))

    def close(self) -> None:
        """Free the pictures."""
        for renderer in self._renderers:
            renderer.close()
