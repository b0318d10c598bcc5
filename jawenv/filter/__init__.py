"""What every step runs to learn: the filter of the environments, and the joint recursion of the bound."""
