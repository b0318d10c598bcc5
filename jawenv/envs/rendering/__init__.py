"""Pictures of one episode: side and front view of the jaw, the twelve posteriors, comfort and progress.

Importing this package does not import pygame; a `Renderer` does when it draws for the first time.
"""

from jawenv.envs.rendering.renderer import Renderer
from jawenv.envs.rendering.scene import Scene

__all__ = ["Renderer", "Scene"]
