"""Data files of the anatomy: every number with unit, source and grade."""
