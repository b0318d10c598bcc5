"""The first minute of a recording at a bench: what is wrong with it, and what mends it."""
