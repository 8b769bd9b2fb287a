"""Sections of the report of `exoid rivals`."""
