"""Searches for maneuvers, and policies that learn a planner's decisions."""
