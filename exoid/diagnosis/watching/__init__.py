"""While it runs, and afterwards: what changed between motion before and motion after, and when."""
