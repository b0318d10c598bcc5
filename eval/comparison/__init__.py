"""``python -m eval compare``: maneuvers and agents on the same patients; tables, and who is ahead by how much."""
