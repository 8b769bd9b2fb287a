"""A command that is run for every event: `--on-event COMMAND`, the event as JSON on its standard input.

It is started directly, by no shell, and nothing of an event is among its arguments. One runs at a time, beside the
watch, in the order of the events.
"""

from __future__ import annotations

import json
import queue
import shlex
import shutil
import subprocess
import threading
import time
from collections.abc import Mapping
from typing import Any

from exoid.workbench.command_line.parser import UsageError
from exoid.workbench.terminal.screen import warn

LIMIT = 30.0
"""s that a command may take."""
WAITING = 1000
"""Events that wait at most."""
LAST = 60.0
"""s that are waited in the end for what is still to be run."""


class Hook:
    """Runs a command for every event it takes; UsageError for a command that there is not."""

    def __init__(self, command: str) -> None:
        try:
            self.words = shlex.split(command)
        except ValueError as error:
            raise UsageError(f"--on-event {command!r} cannot be read: {error}", remedy="close the quotes") from None
        if not self.words or shutil.which(self.words[0]) is None:
            what = f"there is no command {self.words[0] if self.words else ''!r} for --on-event"
            remedy = "name an executable file, with its arguments if it has any; it is run without a shell"
            raise UsageError(what, remedy=remedy)
        self.waiting: queue.Queue[str | None] = queue.Queue(WAITING)
        self.lost = 0
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def take(self, event: Mapping[str, Any]) -> None:
        """Let the command run for an event."""
        try:
            self.waiting.put_nowait(json.dumps(event, ensure_ascii=True, allow_nan=False) + "\n")
        except queue.Full:
            self.lost += 1

    def close(self) -> None:
        """Wait until the command has had every event, or for a minute."""
        end = time.monotonic() + LAST
        while not self.waiting.empty() and time.monotonic() < end:
            time.sleep(0.05)
        self.lost += self.waiting.qsize()
        if not self.waiting.full():
            self.waiting.put(None)
            self.thread.join(max(LIMIT, end - time.monotonic()))
        if self.lost:
            warn(f"{self.words[0]} did not get {self.lost} events: it took too long for those before")

    def _run(self) -> None:
        while (text := self.waiting.get()) is not None:
            try:
                done = subprocess.run(
                    self.words, input=text, text=True, encoding="utf-8", errors="replace", timeout=LIMIT, check=False,
                    stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True,
                )  # fmt: skip
            except subprocess.TimeoutExpired:
                warn(f"{self.words[0]} took more than {LIMIT:g} s for an event and was ended")
            except OSError as error:
                warn(f"{self.words[0]} could not be run: {error.strerror}")
            else:
                if done.returncode:
                    said = (done.stderr.strip().splitlines() or [""])[-1][:200]
                    warn(f"{self.words[0]} ended with status {done.returncode}" + (f": {said}" if said else ""))
