"""Output that a person reads in the terminal: tables, progress, encoding."""
