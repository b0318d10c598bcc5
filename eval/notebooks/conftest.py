"""Keeps the notebooks small when they run as tests."""

import os

os.environ.setdefault("JAWENV_NOTEBOOK_PATIENTS", "3")
os.environ.setdefault("JAWENV_NOTEBOOK_EPISODE_S", "4")
os.environ.setdefault("JAWENV_NOTEBOOK_QUICK", "1")
