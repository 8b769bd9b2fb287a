"""The estimator in C as a format of `exoid export`."""
