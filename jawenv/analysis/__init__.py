"""Limits of any estimator: bound and identifiability."""
