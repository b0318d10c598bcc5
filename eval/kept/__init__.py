"""The engine: cells are played in parts, kept on disk under a digest of all that decides them."""
