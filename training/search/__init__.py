"""Search for maneuvers by the gradient of the differentiable twin, and how far the twin agrees."""
