"""What can be known at all: bound, identifiability and observability."""
