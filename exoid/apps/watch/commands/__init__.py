"""The command that follows a machine."""
