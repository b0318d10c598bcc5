"""All that makes and moves one world: its record, the plants, and the compiled kernels of reset and step."""
