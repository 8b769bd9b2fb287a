"""`exoid rivals` and the optimisers of pymoo; the contest itself is `exoid.optimisation.contest`."""
