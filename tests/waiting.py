"""How tests wait for what other processes and threads do: until it is so, however busy the machine is."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

HUNG = 600.0
"""Seconds by the clock after which a test says that something hangs. It is no measure of speed: the machine may be busy
with anything else."""


def until(true: Callable[[], Any], said: Callable[[], Any] = lambda: "it never came") -> Any:
    """Return what `true()` gives as soon as that is true; AssertionError with what `said()` where it hangs."""
    ends = time.monotonic() + HUNG
    while not (found := true()):
        assert time.monotonic() < ends, said()
        time.sleep(0.02)
    return found
