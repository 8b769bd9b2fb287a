"""What a person touches: command line, figures, report."""
