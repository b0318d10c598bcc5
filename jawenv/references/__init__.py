"""Estimators to compare the online filter with: joint Kalman filters."""
