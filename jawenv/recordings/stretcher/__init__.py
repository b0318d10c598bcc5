"""Logs of a clinic's stretcher, force and opening alone: how stiff the jaw is, and not where."""
