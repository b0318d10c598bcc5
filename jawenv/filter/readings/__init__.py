"""The device's readings in a tick: encoders and load cell, and the choice of usable ones."""
