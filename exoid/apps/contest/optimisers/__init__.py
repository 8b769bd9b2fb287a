"""Optimisers of pymoo, as `exoid/optimisation/optimisers` has its own: one file each."""
