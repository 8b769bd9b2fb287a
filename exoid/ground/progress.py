"""Progress of long work: the share that is done, and what is being done, for whoever wants to know."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[float, str], None]


def silent(fraction: float, text: str) -> None:
    """Report no progress."""


def part_of(progress: Progress, low: float, high: float, before: str = "") -> Progress:
    """Progress that moves another one from `low` to `high`, with the words `before` in front of what is being done."""
    return lambda fraction, text: progress(low + fraction * (high - low), f"{before}{text}")
