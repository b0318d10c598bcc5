"""Sizes of errors that nobody told, learnt at the end of a recording."""
