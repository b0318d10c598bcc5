"""One training run: its configuration, its folder, learning, evaluations, export."""
