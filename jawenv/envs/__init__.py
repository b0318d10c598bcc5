"""Gymnasium environments: the single one, its native vector form, rewards, registration."""
