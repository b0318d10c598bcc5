"""Readings of a device: records, their files, the filter of a bench, and what it finds in them."""
