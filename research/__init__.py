"""Studies of the filter and of the house itself, each a command: ``python -m research.honesty --help``."""
