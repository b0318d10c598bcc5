"""What a device measured: records, their files, and what an estimator returns."""
