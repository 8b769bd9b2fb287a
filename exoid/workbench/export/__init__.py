"""An identified model in the forms a controller or a simulator takes: one file per form, nothing to register.

A module is named as its format; it has `HELP` (one line) and `write(ready, options) -> {file name: content}`.
"""
