"""Everything that answers an observation of jawenv's environments with an action.

Outside of the clone's folder another distribution's package of this name comes first; ``PYTHONPATH=CLONE`` mends that.
"""

from agents.registry import load_agent
from jawenv.playing.agents import Agent
from jawenv.playing.maneuvers import Maneuver

__all__ = ["Agent", "Maneuver", "load_agent"]
