"""The engine: what is played is made in parts, kept by a digest of what decides it, and found again."""
