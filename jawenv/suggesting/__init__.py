"""What to record next of a patient whose recording was identified."""
