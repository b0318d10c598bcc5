"""Columns of a patient's row: one module for each family."""
