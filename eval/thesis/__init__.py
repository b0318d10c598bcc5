"""``python -m eval thesis``: the results of Young (2016) beside what the corrected equations give."""
