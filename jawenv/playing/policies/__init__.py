"""Trained policies: their cards, plain weights in NumPy, and the policies that come with jawenv, in ``shipped``."""
