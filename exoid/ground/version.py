"""Which exoid this is."""

from __future__ import annotations

from importlib import metadata


def version() -> str:
    """Return the installed version, or "0+source" when the packages are used without being installed."""
    try:
        return metadata.version("exoid")
    except metadata.PackageNotFoundError:
        return "0+source"


__version__ = version()
