"""The audit of a recording: what its checks share, and one file per check."""
