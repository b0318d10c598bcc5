"""Studies of the filter and of the house itself, each a command: ``python -m research.honesty --help``.

Outside of the clone's folder another distribution's package of this name comes first; ``PYTHONPATH=CLONE`` mends that.
"""
