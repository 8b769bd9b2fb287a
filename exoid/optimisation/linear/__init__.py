"""Exact fits of parameters the torque is linear in: losses, solvers, certificate, intervals, physical feasibility."""
