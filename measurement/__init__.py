"""What was measured: recordings, their audit, signals, and the virtual test bench."""
