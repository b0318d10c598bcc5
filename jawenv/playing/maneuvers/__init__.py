"""Maneuvers: targets over time for the jaw's channels, in files, and the player that makes actions of them."""

from jawenv.playing.maneuvers.maneuver import Maneuver, maneuver_names
from jawenv.playing.maneuvers.player import Player

__all__ = ["Maneuver", "Player", "maneuver_names"]
