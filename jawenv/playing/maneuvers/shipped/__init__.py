"""The maneuver files that come with jawenv; a file put here has its stem as a name."""
