"""One file per check: `check(recording) -> list[Finding]`; nothing to register."""
