"""Which exoid this is."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from importlib import metadata


def version() -> str:
    """Return the installed version, or "0+source" when the packages are used without being installed."""
    try:
        return metadata.version("exoid")
    except metadata.PackageNotFoundError:
        return "0+source"


__version__ = version()


def versions() -> Mapping[str, str]:
    """Return the versions a result depends on, for the report: exoid, Python and the numerical libraries."""
    found = {"exoid": __version__, "python": sys.version.split()[0]}
    for name in ("numpy", "scipy", "sympy", "casadi"):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found
