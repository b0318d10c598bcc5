"""Learning in every step: the filter of the environments, and the joint recursion of the bound."""
