"""Maneuvers: targets over time for the jaw's channels, in files, and the player that makes actions of them."""

from jawenv.playing.maneuvers.maneuver import Maneuver, Player, maneuver_names

__all__ = ["Maneuver", "Player", "maneuver_names"]
