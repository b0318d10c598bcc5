"""Whether there is a display on which a window would be seen."""

from __future__ import annotations

import os
import sys

from jawenv.base.errors import InputError
from jawenv.base.extras import needs

_UNSEEN = ("dummy", "offscreen")
_DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")
_DRIVERS_OF_DISPLAYS = ("", "x11", "wayland")


def check_display(user: str, remedy: str) -> None:
    """Make sure that a window would be seen. Where it would not, pygame draws it in memory and says nothing.

    Args:
        user: what needs a display, as the message names it.
        remedy: what the message advises.

    Raises:
        InputError: there is no display.
        MissingPackageError: pygame is not installed.
    """
    driver = os.environ.get("SDL_VIDEODRIVER", "")
    if driver in _UNSEEN:
        raise _refusal(f"SDL_VIDEODRIVER is {driver}", user, remedy)
    without = not any(os.environ.get(name) for name in _DISPLAYS)
    if sys.platform.startswith("linux") and without and driver in _DRIVERS_OF_DISPLAYS:
        raise _refusal(f"neither {' nor '.join(_DISPLAYS)} is set", user, remedy)
    _open_display(user, remedy)


def check_window(user: str, remedy: str) -> None:
    """Make sure that a window can be seen, or that ``SDL_VIDEODRIVER`` itself asks for an unseen one.

    Gymnasium's ``check_env`` makes every environment with a window; where there is no display it is run so.

    Args:
        user: as of ``check_display``.
        remedy: as of ``check_display``.

    Raises:
        InputError: there is no display, and no driver that needs none was asked for.
        MissingPackageError: pygame is not installed.
    """
    if os.environ.get("SDL_VIDEODRIVER") not in _UNSEEN:
        check_display(user, remedy)


def _open_display(user: str, remedy: str) -> None:
    """Connect to the display and leave it, unless a window is open already."""
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    with needs("render_mode", "pygame", "render"):
        import pygame
    if pygame.display.get_init():
        return
    try:
        pygame.display.init()
        driver = pygame.display.get_driver()
    except pygame.error as error:
        raise _refusal(str(error), user, remedy) from None
    finally:
        pygame.display.quit()
    if driver in _UNSEEN:
        raise _refusal("that which is set cannot be opened", user, remedy)


def _refusal(reason: str, user: str, remedy: str) -> InputError:
    return InputError(f"{user} needs a display ({reason}); {remedy}")
