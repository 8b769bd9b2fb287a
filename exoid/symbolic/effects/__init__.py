"""The catalogue of physical effects: one file for each, its name is the effect's id, nothing to register."""
