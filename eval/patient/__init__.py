"""``python -m eval patient`` and ``diagnose``: verdicts on a patient after treatments, and how often they are right."""
