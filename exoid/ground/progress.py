"""Progress of long work: the share that is done, and what is being done, for whoever wants to know."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[float, str], None]


def silent(fraction: float, text: str) -> None:
    """Report no progress."""
