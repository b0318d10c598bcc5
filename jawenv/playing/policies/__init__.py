"""Trained policies: their cards, plain weights in NumPy, and those that come with jawenv, in ``shipped``."""
