"""One module per verb: `GROUP`, `HELP`, `add_arguments(parser)`, `run(args) -> int`. A new file is a new command.

These modules are imported to write `exoid --help`, so nothing heavy is imported at their top.
"""
