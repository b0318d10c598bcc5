"""Searches for maneuvers, and what a planner decides as a policy."""
