"""The file of --state with what was learnt: read at the beginning, written as the watch goes on."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

from exoid.ground.errors import refused
from exoid.ground.files import write_whole
from exoid.ground.inputs import read_input
from exoid.ground.lock import FolderHeld, file_lock
from exoid.ground.output import OutputError

if TYPE_CHECKING:
    from exoid.apps.watch.state import WatchState
    from exoid.apps.watch.watcher import Watcher

OFTEN = 60.0
"""s of the wall clock after which it is written again, at least."""


class Kept:
    """The state of a watch in a file, which no other watch writes meanwhile; OutputError where one does."""

    def __init__(self, path: str) -> None:
        self.path = Path(path)
        remedy = "give each watch a --state of its own, or stop the other one"
        with (
            refused(OutputError, "cannot be kept: {}", path, "check that you may write into its folder"),
            refused(OutputError, "another watch keeps what it learns in this file", path, remedy, (FolderHeld,)),
        ):
            self._lock = file_lock(self.path)
        self.written = time.monotonic()
        self.found = -1

    def read(self) -> WatchState | None:
        """Return the state that an earlier watch has left, None where there is no such file yet; StateError for another
        file.
        """
        from exoid.apps.watch.state import LARGEST, StateError, WatchState

        if not self.path.exists():
            return None
        with refused(StateError, "cannot be read: {}", self.path, "check the path"):
            content = read_input(self.path, LARGEST, remember=False)
        return WatchState.from_bytes(content, str(self.path))

    def release(self) -> None:
        """Let another watch have the file."""
        self._lock.release()

    def keep(self, watcher: Watcher, *, last: bool = False) -> None:
        """Write what is known where something has changed since, or a minute has passed; OutputError."""
        news = watcher.found != self.found or time.monotonic() - self.written >= OFTEN
        state = watcher.state() if news or last else None
        if state is None:
            return
        self.written, self.found = time.monotonic(), watcher.found
        with refused(OutputError, "cannot be written: {}", self.path, "check that the folder exists and has room"):
            write_whole(self.path, state.to_bytes(), at_once=True)
