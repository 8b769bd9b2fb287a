"""The command that lets optimisers compete."""
