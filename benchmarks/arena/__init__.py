"""Cases whose truth is sealed, and entries that are asked what is missing in them: exoid and its rivals, alike."""
