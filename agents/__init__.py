"""Everything that answers an observation of jawenv's environments with an action."""

from agents.registry import load_agent, names
from jawenv.playing.agents import Agent
from jawenv.playing.maneuvers import Maneuver

__all__ = ["Agent", "Maneuver", "load_agent", "names"]
