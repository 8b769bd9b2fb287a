"""A progress bar for work that takes over a second; nothing without a terminal or with --quiet."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from exoid.ground.progress import Progress, silent

PATIENCE = 1.0
"""Seconds of silence before a bar appears."""


class _Bar:
    """A rich bar on stderr that a timer shows once the work has lasted `PATIENCE` seconds."""

    def __init__(self, text: str) -> None:
        self._lock = threading.Lock()
        self._fraction, self._text, self._closed = 0.0, text, False
        self._display: Any = None
        self._task: Any = None
        self._timer = threading.Timer(PATIENCE, self._show)
        self._timer.daemon = True
        self._timer.start()

    def __call__(self, fraction: float, text: str) -> None:
        with self._lock:
            self._fraction, self._text = min(1.0, max(self._fraction, fraction)), text
            if self._display is not None:
                self._display.update(self._task, completed=self._fraction, description=self._text)

    def _show(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

        with self._lock:
            if self._closed:
                return
            self._display = Progress(
                SpinnerColumn(), BarColumn(bar_width=28), TextColumn("{task.percentage:>3.0f} %"),
                TimeElapsedColumn(), TextColumn("{task.description}", markup=False),
                console=Console(stderr=True), transient=True,
            )  # fmt: skip
            self._task = self._display.add_task(self._text, total=1.0, completed=self._fraction)
            self._display.start()

    def close(self) -> None:
        with self._lock:
            self._closed = True
            self._timer.cancel()
            if self._display is not None:
                self._display.stop()


@contextmanager
def progress(text: str, *, quiet: bool = False) -> Iterator[Progress]:
    """Yield a `Progress` to report to; `text` says what is being done until the first report."""
    if quiet or not sys.stderr.isatty():
        yield silent
        return
    shown = _Bar(text)
    try:
        yield shown
    finally:
        shown.close()


def part(whole: Progress, start: float, stop: float) -> Progress:
    """Return a progress whose 0..1 is the stretch from `start` to `stop` of `whole`."""

    def report(fraction: float, text: str) -> None:
        whole(start + (stop - start) * min(1.0, max(0.0, fraction)), text)

    return report
