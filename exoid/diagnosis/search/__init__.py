"""The search for missing effects: an engine that applies moves to a list of accepted terms."""
