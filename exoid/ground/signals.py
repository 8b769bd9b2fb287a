"""Signals of the operating system, handled while something is under way."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Callable, Iterator


@contextlib.contextmanager
def handled(handler: Callable[[int, object], None], *names: str) -> Iterator[None]:
    """Let `handler` have the signals called `names`: in the main thread, whose they are, and not those that whoever
    started this process has set to be ignored (nohup, jobs in the background).
    """
    numbers = [number for name in names if (number := getattr(signal, name, None)) is not None]
    if threading.current_thread() is not threading.main_thread():
        numbers = []
    before = {item: signal.signal(item, handler) for item in numbers if signal.getsignal(item) is not signal.SIG_IGN}
    try:
        yield
    finally:
        for number, was in before.items():
            signal.signal(number, signal.SIG_DFL if was is None else was)
