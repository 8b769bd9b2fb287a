"""The virtual test bench: a leg in closed loop, imperfect instruments, hidden effects and their sealed truth."""
