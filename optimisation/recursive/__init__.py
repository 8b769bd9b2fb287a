"""A model's numbers sample by sample, in Python and in C, with intervals that hold while old samples are forgotten."""
