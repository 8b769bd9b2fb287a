"""What the recordings say for and against each candidate, placebo and recording, given a fitted model."""
