"""The filter of the environments, its files in the order of the data."""
