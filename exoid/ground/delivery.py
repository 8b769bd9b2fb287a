"""The files of one command: they appear together at its end or not at all, and none replaces a file it read.

Inside `together()` every file is written whole, under a name of its own, beside the place it is meant for; what goes
wrong until the end leaves every place as it was. Outside of it a file is put in place at once.

One temporary folder and `os.replace` would not do: --out, --write and --json lead to different disks, between which
nothing is replaced in one step; and where one of three files cannot be put in place, the others have to go back.
"""

from __future__ import annotations

import contextlib
import errno
import io
import os
import shutil
import signal
import stat
import tempfile
import time
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from exoid.ground.inside import is_inside, refuse_links
from exoid.ground.ours import OTHERS, is_folder_of_ours, is_ours
from exoid.ground.signals import handled

PREFIX, SUFFIX = ".exoid-", ".part"
ABANDONED = 86_400.0
"""Seconds after which an unfinished file counts as left behind by a process that was killed."""

Write = Callable[[IO[bytes]], object]


Identity = tuple[int, int, int]
"""Device, number and time of change of a file."""


@dataclass(frozen=True)
class Staged:
    """A whole file at `temporary` that is to become `target`, where `before` was (None: nothing), `inside` a folder
    in which no link is followed (None: anywhere).
    """

    temporary: Path
    target: Path
    before: Identity | None
    inside: Path | None = None


@dataclass(eq=False)
class Delivery:
    """Files that one command has read and is going to write.

    `found` is what was at a place when it was first looked at: what somebody else writes there meanwhile is not
    replaced, unless `force` says so. `results` are the folders that it fills, in which no link is followed but at the
    places that were `named` by themselves, and nothing is replaced that somebody else wrote; `ours` says which of them
    exoid had filled before.
    """

    read: dict[tuple[int, int], str] = field(default_factory=dict)
    staged: dict[Path, Staged] = field(default_factory=dict)
    found: dict[Path, Identity | None] = field(default_factory=dict)
    force: bool = False
    direct: list[tuple[Path, bytes]] = field(default_factory=list)
    folders: list[Path] = field(default_factory=list)
    results: list[Path] = field(default_factory=list)
    named: set[str] = field(default_factory=set)
    ours: dict[Path, bool] = field(default_factory=dict)

    def note(self, status: os.stat_result, path: str | Path) -> None:
        """Remember a file that was read: it is not written to."""
        self.read[status.st_dev, status.st_ino] = str(path)

    def fills(self, path: str | Path) -> Path | None:
        """Return the folder of results in which `path` lies; None where there is none, or it was named by itself."""
        if os.path.abspath(path) in self.named:
            return None
        return next((folder for folder in self.results if is_inside(path, folder)), None)

    def fill(self, folder: Path) -> None:
        """Take `folder` for one that this command fills."""
        self.results.append(folder)
        self.ours.setdefault(folder, is_folder_of_ours(folder))

    def keep_others(self, path: str | Path) -> None:
        """Raise OSError where `path` is in a folder that is filled, and holds a file that somebody else wrote."""
        filled, target = self.fills(path), Path(path)
        if filled is not None and target.is_file() and not is_ours(target, self.ours.get(filled, False)):
            raise OSError(errno.EEXIST, OTHERS.format(target.name), str(path))

    def add(self, path: str | Path, write: Write, inside: Path | None = None) -> Path:
        """Let `write(stream)` make the file that is to become `path`; OSError where that cannot be."""
        if inside is None:
            self.keep_others(path)
        inside = inside or self.fills(path)
        target = self.place(path, inside)
        if not _replaceable(target):
            content = io.BytesIO()
            write(content)
            self.direct.append((target, content.getvalue()))
            return Path(path)
        self.make_folder(target.parent)
        temporary = _written(target, write)
        twice = self.staged.get(target)
        if twice is not None:
            same = twice.temporary.read_bytes() == temporary.read_bytes()
            (twice.temporary if same else temporary).unlink()
            if not same:
                raise OSError(errno.EEXIST, "two results of this command would go into this one file", str(path))
        real = None if inside is None else Path(os.path.realpath(inside))
        self.staged[target] = Staged(temporary, target, self.found[target], real)
        return Path(path)

    def place(self, path: str | Path, inside: Path | None = None) -> Path:
        """Place where `path` really is; OSError where it is a file that was read, or must not be written."""
        if inside is not None:
            refuse_links(path, inside)
        target, status = _resolved(path)
        if status is not None and (status.st_dev, status.st_ino) in self.read:
            source = self.read[status.st_dev, status.st_ino]
            also = "" if source == str(path) else f" as {source}"
            raise OSError(
                errno.EEXIST, f"this file is read here{also}, and what is read is never written to", str(path)
            )
        self.found.setdefault(target, None if status is None else _identity(status))
        return target

    def make_folder(self, folder: Path) -> None:
        """Make `folder` with its parents; those that were not there are removed again if nothing comes of it."""
        missing = [place for place in (folder, *folder.parents) if not place.exists()]
        folder.mkdir(parents=True, exist_ok=True)
        self.folders += reversed(missing)

    def now(self, path: Path) -> Path:
        """Place of the content of `path` at this moment."""
        staged = self.staged.get(_resolved(path)[0])
        return path if staged is None else staged.temporary

    def commit(self) -> None:
        """Put every file in its place; where one cannot be, all places get back what they held."""
        several = len(self.staged) + len(self.direct) > 1  # one by itself changes places in one step
        done: list[tuple[Staged, Path | None, bool]] = []
        with _undisturbed():
            try:
                for stage in self.staged.values():
                    self._check(stage)
                for place, content in self.direct:
                    _write_into(place, content)
                for item in self.staged.values():
                    kept = _kept(item.target) if several else None
                    done.append((item, kept, False))
                    _put(item, force=self.force)
                    done[-1] = item, kept, True
            except BaseException:
                for entry, kept, there in reversed(done):
                    with contextlib.suppress(OSError):
                        if kept is not None:
                            os.replace(kept, entry.target)
                        elif there and several:
                            entry.target.unlink(missing_ok=True)
                raise
            for _, kept, _ in done:
                if kept is not None:
                    kept.unlink(missing_ok=True)
            self.folders.clear()
            self._clear()

    def _check(self, one: Staged) -> None:
        """Raise OSError where a place has been read since, or written to by somebody else."""
        self.place(one.target, one.inside)
        now = _identity(one.target.stat()) if one.target.exists() else None
        if now != one.before and not self.force:
            raise OSError(errno.EEXIST, "another process has written this file meanwhile", str(one.target))

    def discard(self) -> None:
        """Remove what was not put in place."""
        with _undisturbed():
            self._clear()
            for folder in reversed(self.folders):
                with contextlib.suppress(OSError):  # something else is in it by now
                    folder.rmdir()

    def _clear(self) -> None:
        for stage in self.staged.values():
            stage.temporary.unlink(missing_ok=True)
        self.staged.clear()
        self.direct.clear()


_OPEN: ContextVar[Delivery | None] = ContextVar("delivery", default=None)


@contextlib.contextmanager
def together() -> Iterator[Delivery]:
    """Let all files written inside appear together at the end; after an exception none of them does."""
    delivery = Delivery()
    token = _OPEN.set(delivery)
    try:
        yield delivery
        delivery.commit()
    except BaseException:
        delivery.discard()
        raise
    finally:
        _OPEN.reset(token)


def current() -> Delivery | None:
    """Return the delivery that is open here, if one is."""
    return _OPEN.get()


def where(path: str | Path) -> Path:
    """Place of the content of `path` at this moment: beside it, as long as the delivery that makes it is open."""
    delivery = _OPEN.get()
    return Path(path) if delivery is None else delivery.now(Path(path))


def deliver(path: str | Path, write: Write, *, at_once: bool = False, inside: Path | None = None) -> Path:
    """Write a file with the others of the open delivery; at once where none is open, or `at_once` says so."""
    delivery = _OPEN.get()
    if delivery is not None and not at_once:
        return delivery.add(path, write, inside)
    alone = Delivery(force=True)
    if delivery is not None:
        alone.read, alone.results, alone.named = delivery.read, delivery.results, delivery.named
        alone.ours = delivery.ours
    try:
        alone.add(path, write, inside)
        alone.commit()
    except BaseException:
        alone.discard()
        raise
    return Path(path)


def _resolved(path: str | Path) -> tuple[Path, os.stat_result | None]:
    """Return the path without links, and what is there."""
    try:
        status = os.stat(path)
    except FileNotFoundError:
        return Path(os.path.realpath(path)), None
    except ValueError as error:
        raise OSError(errno.EINVAL, "this is not a path of a file", str(path)) from error
    if stat.S_ISDIR(status.st_mode):
        raise IsADirectoryError(errno.EISDIR, "this is a folder", str(path))
    if stat.S_ISBLK(status.st_mode) or stat.S_ISSOCK(status.st_mode):
        raise OSError(errno.EINVAL, "this is a disk or a socket, not a file", str(path))
    if stat.S_ISREG(status.st_mode) and not status.st_mode & 0o222:
        raise PermissionError(errno.EACCES, "this file is write-protected", str(path))
    if stat.S_ISREG(status.st_mode) and not _is_stream(path):
        return Path(os.path.realpath(path)), status
    return Path(path), status


def _is_stream(path: str | Path) -> bool:
    """True if the path names an open stream of a process, such as /dev/stdout or /dev/fd/3, wherever that leads."""
    text = str(path)
    if os.path.islink(text):
        text = os.path.join(os.path.dirname(text), os.readlink(text))
    return os.path.realpath(os.path.dirname(text) or ".").startswith("/proc/")


def _replaceable(target: Path) -> bool:
    """True if a file can be put in place here; a device or a pipe is written into instead."""
    return not os.path.exists(target) or (os.path.isfile(target) and not _is_stream(target))


def _written(target: Path, write: Write) -> Path:
    """Return a whole file beside `target`, with the access rights the target has or would get."""
    sweep(target.parent, f"{PREFIX}*{SUFFIX}")
    handle, name = tempfile.mkstemp(prefix=PREFIX, suffix=SUFFIX, dir=target.parent)
    try:
        with os.fdopen(handle, "wb") as stream:
            write(stream)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(name, stat.S_IMODE(target.stat().st_mode) if target.exists() else 0o666 & ~_umask())
    except BaseException as error:
        Path(name).unlink(missing_ok=True)
        if isinstance(error, OSError) and error.filename is None:
            raise OSError(error.errno, error.strerror or str(error), str(target)) from error
        raise
    return Path(name)


def _put(one: Staged, *, force: bool) -> None:
    """Give a staged file its name; FileExistsError where nothing was to be there and something is."""
    if one.before is None and not force:
        with contextlib.suppress(PermissionError, NotImplementedError):  # a file system without hard links
            os.link(one.temporary, one.target)
            return
    os.replace(one.temporary, one.target)


def _identity(status: os.stat_result) -> Identity:
    return status.st_dev, status.st_ino, status.st_mtime_ns


def _write_into(place: Path, content: bytes) -> None:
    """Write into a device or a pipe; OSError where nobody reads from the pipe."""
    try:
        handle = os.open(place, os.O_WRONLY | getattr(os, "O_NONBLOCK", 0))
    except OSError as error:
        if error.errno == errno.ENXIO:
            raise OSError(errno.ENXIO, "nobody reads from this pipe", str(place)) from error
        raise
    if hasattr(os, "set_blocking"):
        os.set_blocking(handle, True)
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(content)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(place)) from error


def _kept(target: Path) -> Path | None:
    """Return a second name for what is at `target`, None where nothing is."""
    if not target.exists():
        return None
    handle, name = tempfile.mkstemp(prefix=PREFIX, suffix=SUFFIX, dir=target.parent)
    os.close(handle)
    kept = Path(name)
    kept.unlink()
    try:
        os.link(target, kept)
    except OSError:  # a file system without hard links; not renamed, or a moment would see no file at all
        shutil.copy2(target, kept)
    return kept


def sweep(folder: Path, *patterns: str, age: float = ABANDONED) -> None:
    """Remove what processes that were killed left behind in `folder` more than `age` s ago: files and folders."""
    for left in (path for pattern in patterns for path in folder.glob(pattern)):
        with contextlib.suppress(OSError):
            if time.time() - left.lstat().st_mtime > age:
                shutil.rmtree(left) if left.is_dir() else left.unlink()


@contextlib.contextmanager
def _undisturbed() -> Iterator[None]:
    """Hold Ctrl-C, SIGTERM and SIGHUP back for the moment in which files change places."""
    held: list[int] = []
    try:
        # Not by a mask: another thread, such as one of a numerical library, would take the signal and hand it on.
        with handled(lambda number, _: held.append(number), "SIGINT", "SIGTERM", "SIGHUP"):
            yield
    finally:
        if held:
            signal.raise_signal(held[0])


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
