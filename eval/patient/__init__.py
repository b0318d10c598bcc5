"""``python -m eval patient``: verdicts on a patient after treatments."""
