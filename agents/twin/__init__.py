"""A differentiable twin of an environment in torch: quasi-static poses, the filter's information, comfort and guard."""
