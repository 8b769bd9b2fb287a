"""Signals of a recording: uniform sampling, filtering, derivatives and their noise."""
