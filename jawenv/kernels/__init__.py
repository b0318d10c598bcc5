"""What every kernel stands on: how kernels are compiled and kept, small algebra, vectors, noise."""
