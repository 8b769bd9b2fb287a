"""The folder in which a session is kept: held by one process, recordings by their content, `session.json` in one step.

What `session.json` names is there before it says so, and is never written again: a process that is killed at any moment
leaves the old session or the new one. No link in the folder is followed, and what exoid has not made is left alone.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import stat
import tempfile
import threading
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from exoid.apps.page.given import safe_name
from exoid.ground.delivery import PREFIX, SUFFIX, deliver, sweep
from exoid.ground.errors import RecordingError, refused
from exoid.ground.files import sha256, sha256_file, write_whole
from exoid.ground.inputs import open_input, read_input
from exoid.ground.inside import is_inside, refuse_links
from exoid.ground.lock import LOCK, FolderHeld, FolderLock

SESSION = "session.json"
LARGEST = 100_000_000
"""Bytes of a session.json; one has some thousand."""
RECORDINGS = "recordings"
DIGITS = 32
"""Hexadecimal digits of the content's SHA-256 in the name of a copy."""
LONGEST_STEM = 32
"""Letters of a recording's name in that of its copy, so that a browser which drops it hands on all of it."""
COPY = re.compile(rf".+-[0-9a-f]{{{DIGITS}}}(\.[^.]*)?")
NAME = re.compile(rf"base\.toml|{RECORDINGS}/[A-Za-z0-9_-][A-Za-z0-9._-]*")
"""Copies as a session.json may name them; those of older ones are numbered."""
CLOSED = "-closed"
"""What the folder beside a session is called that takes recordings which are no longer in it."""


class SessionFolder:
    """A folder that this process holds, until `release`. RecordingError where another one has it or has changed it."""

    def __init__(self, folder: Path) -> None:
        self.folder = Path(os.path.realpath(folder))
        elsewhere = "close it there, or save this one to another folder"
        with (
            refused(RecordingError, "the session cannot be kept ({})", folder, "choose a folder you may write to"),
            refused(RecordingError, "another exoid has this session open", folder, elsewhere, (FolderHeld,)),
        ):
            made = not self.folder.exists()
            self.folder.mkdir(parents=True, exist_ok=True)
            refuse_links(self.folder / RECORDINGS, self.folder)
            self._lock = _lock_of(self.folder)
            try:
                self.read()
            except BaseException:
                self.release()
                raise
        self._made = made
        self.writing = threading.Lock()
        self._copied: dict[str, Path] = {}
        self._seen: dict[Any, Path] = {}
        for place in (self.folder, self.folder / RECORDINGS):
            sweep(place, f"{PREFIX}*{SUFFIX}", age=0.0)  # nobody else writes here

    def release(self) -> None:
        """Let other processes have it; nothing stays of a folder in which nothing was kept."""
        if self._made and set(os.listdir(self.folder)) <= {LOCK}:
            with contextlib.suppress(OSError):
                (self.folder / LOCK).unlink()
                self.folder.rmdir()
        _unlock(self.folder)

    def copy(self, source: Path, called: str, digest: str = "") -> str:
        """Return the name, in this folder, of a copy of `source` that is named after `called` and what it holds.

        What lies in the folder already stays where it is. `digest` is the SHA-256 of what was read of it ("": unknown):
        RecordingError where it is not that any more.
        """
        if is_inside(os.path.realpath(source), self.folder):
            return Path(os.path.realpath(source)).relative_to(self.folder).as_posix()
        from exoid.measurement.reading.sources import digest as digest_of
        from exoid.measurement.reading.sources import opened

        known, seen = self._named(called, digest) if digest else None, _identity(source)
        if known is None and seen is not None:
            known = self._seen.get((source, called, seen))
        if known is not None and known.name in self._copied and known.exists():
            return known.relative_to(self.folder).as_posix()
        with opened(source) as real:
            found = digest_of(real)
            if digest and found != digest:
                what = "it has changed since it was read, so it cannot be kept as it was"
                raise RecordingError(what, where=str(source), remedy="close it and open it again")
            target = self._named(called, found)
            refuse_links(target, self.folder)
            if not (target.exists() and digest_of(target) == found):
                self._take(real, target)
        self._copied[target.name] = source
        self._seen[source, called, seen] = target
        return target.relative_to(self.folder).as_posix()

    def copy_base(self, source: Path) -> str:
        """Return the name, in this folder, of a copy of the model file that everything starts from."""
        if is_inside(os.path.realpath(source), self.folder):
            return Path(os.path.realpath(source)).relative_to(self.folder).as_posix()
        text = source.read_bytes()
        target = self.folder / f"base-{sha256(text)[:DIGITS]}{source.suffix.lower()}"
        write_whole(target, text, at_once=True, inside=self.folder)
        self._copied[target.name] = source
        return target.name

    def read(self) -> bytes:
        """Return the session as it stands there, from which one goes on."""
        text = self.present()
        self._known = sha256(text)
        return text

    def check(self) -> None:
        """Raise RecordingError unless the session there is the one that was read or written last."""
        if sha256(self.present()) != self._known:
            what = "the session there was changed by somebody else, and is not written over"
            remedy = "save this one to another folder, or open that one again"
            raise RecordingError(what, where=str(self.folder), remedy=remedy)

    def write(self, text: str) -> None:
        """Put a new session in the place of the one that was read or written last."""
        self.check()
        write_whole(self.folder / SESSION, text, at_once=True, inside=self.folder)
        self._known = sha256(text)

    def tidy(self, named: Iterable[str], before: Iterable[str], dropped: Path) -> None:
        """Take away the copies that the session does not name: those it named `before`, and those of killed processes.

        A copy of what lies elsewhere, or was dropped into the page (a file in `dropped`), is deleted. Any other may be
        the only one, and goes to a folder beside this one.
        """
        kept = set(named)
        runs = self.folder / RECORDINGS
        ours = {path for path in self.folder.glob("base-*") if COPY.fullmatch(path.name)}
        ours |= {path for path in runs.glob("*") if COPY.fullmatch(path.name)}
        ours |= {self.folder / name for name in before if NAME.fullmatch(name)}
        for path in sorted(ours):
            if path.relative_to(self.folder).as_posix() in kept or path.is_symlink() or not path.exists():
                continue
            source = self._copied.pop(path.name, None)
            if source is not None and (source.exists() or is_inside(source, dropped)):
                _remove(path)
            else:
                self._set_aside(path)

    def present(self) -> bytes:
        """Return the session as it stands there, nothing where there is none."""
        try:
            return read_input(self.folder / SESSION, LARGEST, remember=False, inside=self.folder)
        except FileNotFoundError:
            return b""

    def _named(self, content: str, digest: str) -> Path:
        name = Path(safe_name(content))
        return self.folder / RECORDINGS / f"{name.stem[:LONGEST_STEM]}-{digest[:DIGITS]}{name.suffix[:12]}"

    def _take(self, real: Path, target: Path) -> None:
        """Copy a file, or a folder of files, in one step."""
        if not real.is_dir():
            with open_input(real, remember=False) as stream:
                deliver(target, lambda out: shutil.copyfileobj(stream, out), at_once=True, inside=self.folder)
            return
        refuse_links(target, self.folder)
        target.parent.mkdir(exist_ok=True)
        part = Path(tempfile.mkdtemp(prefix=PREFIX, suffix=SUFFIX, dir=target.parent))
        for file in sorted(path for path in real.iterdir() if path.is_file()):
            shutil.copyfile(file, part / file.name)
        _remove(target)
        part.rename(target)

    def _set_aside(self, path: Path) -> None:
        aside = self.folder.with_name(self.folder.name + CLOSED)
        refuse_links(aside, aside.parent)
        aside.mkdir(exist_ok=True)
        target = aside / path.name
        if target.exists() and not COPY.fullmatch(path.name):
            target = aside / f"{path.stem}-{sha256_file(path)[:DIGITS]}{path.suffix}"
        _remove(target)
        shutil.move(path, target)


def inside(folder: Path, name: Any) -> Path:
    """Return a file of a saved session; ValueError where it is not in its folder, or not what was kept there."""
    from exoid.measurement.reading.sources import digest

    path = folder / str(name)
    try:
        for part in (path, *(path.iterdir() if path.is_dir() else ())):
            refuse_links(part, folder)
        if COPY.fullmatch(path.name) and digest(path)[:DIGITS] not in path.name:
            raise ValueError(f"{name} is not what was kept there")
    except OSError as error:
        raise ValueError(f"{name}: {error.strerror}") from error
    return Path(os.path.realpath(path))


def _identity(source: Path) -> tuple[int, int, int, int] | None:
    """Return a key that changes with a file's content; None where it is no file by itself (a folder, part of an
    archive).
    """
    with contextlib.suppress(OSError):
        status = os.stat(source)
        if stat.S_ISREG(status.st_mode):
            return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns
    return None


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


_HELD: dict[Path, list[FolderLock]] = {}
"""The locks of this process: all its workspaces share them."""


def _lock_of(folder: Path) -> FolderLock | None:
    locks = _HELD.setdefault(folder, [])
    locks.append(locks[0] if locks else FolderLock(folder))
    return locks[0]


def _unlock(folder: Path) -> None:
    locks = _HELD.get(folder, [])
    if locks and (last := locks.pop()) and not locks:
        last.release()
        del _HELD[folder]
