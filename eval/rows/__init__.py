"""What is kept of a patient: one module for each family of columns."""
