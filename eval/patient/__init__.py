"""``python -m eval patient`` and ``diagnose``: what treatments tell of one patient, and how often that is right."""
