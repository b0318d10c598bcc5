"""The model that estimators share: one discrete step and its derivative, encoders, load cell."""
