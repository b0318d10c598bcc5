"""Pictures of one episode: side and front view of the jaw, the posteriors, comfort and the motion over time.

Importing this package does not import pygame; a `Renderer` does when it draws for the first time.
"""

from jawenv.envs.rendering.renderer import Renderer
from jawenv.envs.rendering.scene import Scene

__all__ = ["Renderer", "Scene"]
