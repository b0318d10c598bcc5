"""The base of every kernel: compiler and cache, small algebra, vectors, noise."""
