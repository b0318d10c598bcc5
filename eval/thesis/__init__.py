"""``python -m eval study thesis``: the results of Young (2016) beside results of the corrected equations."""
