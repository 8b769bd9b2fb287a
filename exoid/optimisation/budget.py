"""How much an optimiser may evaluate unless told otherwise."""

INDIVIDUALS, GENERATIONS = 40, 400
"""The paper's population and number of generations."""
