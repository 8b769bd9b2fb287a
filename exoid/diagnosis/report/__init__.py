"""The report: one HTML file that needs nothing else, made of sections that are one file each."""
