"""A differentiable twin of an environment in torch: quasi-static poses, the filter's information, comfort and guard."""

MODEL = "jaw"
"""Model of the ladder of which it is the twin."""
