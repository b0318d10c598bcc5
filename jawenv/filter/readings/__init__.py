"""What the device reads in a tick: encoders and load cell, and which of their readings are usable."""
