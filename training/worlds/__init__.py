"""Worlds as stable-baselines3 trains on them."""
