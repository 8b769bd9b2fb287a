"""Formats of `exoid export`, as `exoid/workbench/export` has its own: one file each."""
