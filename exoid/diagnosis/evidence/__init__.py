"""Evidence of the recordings for and against each candidate, placebo and recording, given a fitted model."""
