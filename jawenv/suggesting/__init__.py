"""A movement to record next, for a patient with an identified recording."""
