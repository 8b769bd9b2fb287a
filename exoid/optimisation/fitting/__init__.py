"""From prepared samples to a fitted model: shape parameters, identification, plausibility."""
