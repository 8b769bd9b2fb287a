"""Optimisers compared with the certified optimum: runs, statistics, running times, pictures."""
