"""Figures of patients: estimates with their intervals, how they are written, and the tables of them."""
