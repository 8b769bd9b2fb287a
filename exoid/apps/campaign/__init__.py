"""Many recordings or simulated legs: a plan, its jobs, the engine that runs them, one table and one page."""
