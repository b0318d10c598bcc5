"""Readings of a device: records, their files, and the result of an estimator."""
