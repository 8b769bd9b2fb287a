"""The command that asks about many recordings."""
