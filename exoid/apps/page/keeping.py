"""A session kept in a folder: written after every change, in a thread of its own, whatever else goes on."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from exoid.ground.errors import ExoidError

if TYPE_CHECKING:
    from exoid.apps.page.folder import SessionFolder


class Keeping:
    """Writes a session to its folder, the `place`, once it has one. `change` is notified of every change of the
    session, and of its end (`closed`); `told` is called when it is written.
    """

    def __init__(self, change: threading.Condition, closed: Callable[[], bool], told: Callable[[], object]) -> None:
        self._change, self._closed, self._told = change, closed, told
        self.place: SessionFolder | None = None
        self.unkept: ExoidError | None = None
        """Why the session cannot be kept where it should be."""
        self._session: Callable[[], object] | None = None
        self._report: Callable[[], object] = lambda: None
        self._reported: object = None
        self._changes = self._written = 0

    @property
    def folder(self) -> Path | None:
        """The folder in which the session is kept; None where it is not."""
        return None if self.place is None else self.place.folder

    def keep_in(self, place: SessionFolder, session: Callable[[], object], report: Callable[[], object]) -> None:
        """From now on write the session and its report to `place` with these."""
        if self.place is not place:
            self.release()
        self.place, self._session, self._report = place, session, report

    def release(self) -> None:
        """Let other processes have the folder."""
        place, self.place, self._session = self.place, None, None
        if place is not None:
            place.release()

    def changed(self) -> None:
        """Take note that there is something new to write; the caller notifies."""
        self._changes += 1

    @property
    def kept(self) -> bool:
        """True if everything that was done is written, where there is a folder to write it to."""
        return self._session is not None and self._written == self._changes and self.unkept is None

    def run(self) -> None:
        """Write after every change, until it is closed."""
        while not self._closed():
            with self._change:
                self._change.wait_for(lambda: self._closed() or self._due)
            self.write()

    def write(self) -> None:
        """Write what is not written yet."""
        if self._due and self._session is not None:
            changes = self._changes
            self._write(self._session)
            self._written = changes
            self._told()

    def reporting(self, shown: object) -> Callable[[], object] | None:
        """Return a function that writes the report, in a thread of its own; None where it shows `shown` already."""
        if self.folder is None or self._reported == shown:
            return None
        self._reported = shown
        return threading.Thread(target=self._write, args=(self._report,), daemon=True).start

    @property
    def _due(self) -> bool:
        return self._session is not None and self._written != self._changes

    def _write(self, write: Callable[[], object]) -> None:
        """Write what is kept; a full disk is said, and everything else goes on."""
        self.unkept = None
        try:
            write()
        except (ExoidError, OSError) as error:
            self.unkept = error if isinstance(error, ExoidError) else ExoidError(str(error.strerror or error))
