"""Whether the belief is to be trusted: readings that the model does not explain, and a belief that drifts."""
