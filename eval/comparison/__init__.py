"""``python -m eval compare``: maneuvers and agents on the same patients, their tables, ranking and differences."""
