"""Motions designed to be informative: criteria, search space, search, reference, result."""
