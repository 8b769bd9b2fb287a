"""Commands that a campaign can ask about recordings, one file each, called as the command: its `VERB`."""
