"""Limits of any estimator: bound, identifiability and observability."""
