"""Packages that are installed on request only, and the extra that brings each."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from exoid.ground.errors import ExoidError


@contextlib.contextmanager
def needing(
    extra: str,
    what: str,
    package: str = "",
    *,
    where: object = "",
    instead: str = "",
    error: type[ExoidError] = ExoidError,
) -> Iterator[None]:
    """Raise `error` where an import inside fails: `what` (in the plural) need a package that `extra` brings.

    `package` is its name where it is imported under another; `instead` is what else one can do.
    """
    try:
        yield
    except ImportError as missing:
        name = package or str(missing.name).partition(".")[0]
        raise error(
            f"{what} need the package {name}, which is not installed",
            where=str(where),
            remedy=f"pip install 'exoid[{extra}]'{instead}",
        ) from missing


def version_of(package: str) -> str | None:
    """Return the version of an installed package, None where it is not installed."""
    from importlib import metadata

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None
