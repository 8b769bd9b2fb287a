"""A model's parameters sample by sample, in Python and C, with intervals that hold while old samples are forgotten."""
