"""Searches for maneuvers: by CMA-ES in the environment, and by the gradient of its differentiable twin."""
