"""The command that makes the paper again."""
