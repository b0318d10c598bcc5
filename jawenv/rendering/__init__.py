"""Pictures of one episode: side and front view of the jaw, the posteriors, comfort and the motion over time.

Importing this package does not import pygame; a `Renderer` does when it draws for the first time.
"""

from jawenv.rendering.renderer import Renderer
from jawenv.rendering.scene import Scene

__all__ = ["Renderer", "Scene"]
