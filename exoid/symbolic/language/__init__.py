"""The torque language: tokens, tree, parser, and its translation into other languages."""
