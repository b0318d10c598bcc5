"""Everything that answers an observation of jawenv's environments with an action."""

from agents.maneuver import Maneuver
from agents.protocol import Agent
from agents.registry import load_agent, names

__all__ = ["Agent", "Maneuver", "load_agent", "names"]
