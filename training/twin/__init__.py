"""The differentiable twin's agreement with the filter, and a search of maneuvers by its gradient."""
