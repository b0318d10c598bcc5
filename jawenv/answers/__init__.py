"""Answers to recordings of one patient: printed, and as JSON."""
