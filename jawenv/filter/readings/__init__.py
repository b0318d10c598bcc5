"""The device's readings in a tick: their least noise, the load cell's trend, and the choice of usable ones."""
