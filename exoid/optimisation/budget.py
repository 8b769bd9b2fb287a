"""Default number of evaluations of an optimiser."""

INDIVIDUALS, GENERATIONS = 40, 400
"""The paper's population and number of generations."""
