"""Turns scenes into arrays or into a window."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from jawenv.base.errors import InputError
from jawenv.base.extras import needs
from jawenv.rendering.scene import Moment, Scene

if TYPE_CHECKING:
    import pygame

    from jawenv.rendering.canvas import Canvas
    from jawenv.rendering.frame import Frame

Mode = Literal["rgb_array", "human"]
_SMALLEST = (480, 270)


class Renderer:
    """Draws the scenes of one environment.

    With mode "rgb_array" nothing needs or touches a display. With "human" a window opens at the first `show`;
    once the user has closed it, it stays closed and `show` does nothing.
    """

    def __init__(self, mode: Mode, fps: float, size: tuple[int, int] = (1280, 720)) -> None:
        """Check the settings; pygame is imported when the first scene is drawn.

        Args:
            mode: "rgb_array" or "human".
            fps: pictures per second of the window.
            size: width and height in pixels.
        """
        if mode not in get_args(Mode):
            raise InputError(f"render_mode is '{mode}'; allowed: {', '.join(get_args(Mode))}")
        if not (np.isfinite(fps) and fps > 0):
            raise InputError(f"fps is {fps}; allowed: numbers above 0")
        if len(size) != 2 or any(side < least for side, least in zip(size, _SMALLEST, strict=False)):
            raise InputError(f"size is {size}; allowed: at least {_SMALLEST[0]} by {_SMALLEST[1]} pixels")
        self.mode = mode
        self.fps = fps
        self.size = (int(size[0]), int(size[1]))
        self._trace: list[Moment] = []
        self._frame: Frame | None = None
        self._window: pygame.Surface | None = None
        self._clock: pygame.time.Clock | None = None
        self._dismissed = False

    def __getstate__(self) -> dict[str, Any]:
        """A copy keeps the trace, and opens a window of its own."""
        return vars(self) | {"_frame": None, "_window": None, "_clock": None, "_dismissed": False}

    def note(self, moment: Moment) -> None:
        """Keep a moment for the trace, whether or not it is drawn."""
        while self._trace and self._trace[-1][0] >= moment[0]:
            self._trace.pop()
        self._trace.append(moment)

    def draw(self, scene: Scene) -> NDArray[np.uint8]:
        """Draw a scene off-screen.

        Returns:
            A new array (height, width, 3).
        """
        return self._picture(scene).pixels()

    def show(self, scene: Scene) -> None:
        """Show a scene in the window, wait for the next picture's turn and see to the window's events."""
        if self._dismissed:
            return
        surface = self._picture(scene).finish()
        import pygame

        window = self._open()
        if any(event.type == pygame.QUIT for event in pygame.event.get()):
            self._dismissed = True
            self._close_window()
            return
        window.blit(surface, (0, 0))
        pygame.display.flip()
        assert self._clock is not None
        self._clock.tick(self.fps)

    def reset(self) -> None:
        """Forget the motion of the past episode."""
        self._trace.clear()

    def close(self) -> None:
        """Close the window, if there is one, and free the picture; may be called twice."""
        self._close_window()
        self._frame = None
        self._dismissed = False
        self._trace.clear()

    def _picture(self, scene: Scene) -> Canvas:
        if self._frame is None:
            os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
            with needs("render_mode", "pygame", "render"):
                from jawenv.rendering.frame import Frame

            self._frame = Frame(self.size)
        self.note(scene.moment)
        return self._frame.draw(scene, self._trace)

    def _open(self) -> pygame.Surface:
        if self._window is None:
            import pygame

            try:
                pygame.display.init()
                self._window = pygame.display.set_mode(self.size)
            except pygame.error as error:
                raise InputError(f"render_mode: 'human' needs a display ({error}); use 'rgb_array'") from None
            pygame.display.set_caption("jawenv")
            self._clock = pygame.time.Clock()
        return self._window

    def _close_window(self) -> None:
        if self._window is not None:
            import pygame

            pygame.display.quit()
            self._window = self._clock = None
