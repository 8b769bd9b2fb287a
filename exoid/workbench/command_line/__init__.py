"""The command line: options, inputs, output files."""
