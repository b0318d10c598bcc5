"""The joint recursion of motion and parameters, which the bound and the reference filters share."""
