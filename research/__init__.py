"""Studies that justify numbers of the project: each module prints its table."""
