"""Everything that answers an observation of jawenv's environments with an action."""

from agents.registry import load_agent, names
from jawenv.playing.maneuvers import Maneuver
from jawenv.playing.protocol import Agent

__all__ = ["Agent", "Maneuver", "load_agent", "names"]
