"""What a person reads in the terminal: tables, progress, encoding."""
