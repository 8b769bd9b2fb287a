"""Blind trials of the diagnosis on the virtual bench: drawn, run, counted."""
