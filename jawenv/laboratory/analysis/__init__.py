"""What can be known at all: bound, identifiability, observability, and their wording."""
