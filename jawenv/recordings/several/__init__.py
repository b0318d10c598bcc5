"""Several recordings of one patient: one belief, and whether they agree."""
