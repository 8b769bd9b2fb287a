"""A folder or a file held by one process at a time, for as long as that lives: one that is killed holds nothing."""

from __future__ import annotations

import contextlib
import errno
import glob
import os
import shutil
import tempfile
from pathlib import Path

from exoid.ground.inside import refuse_links

LOCK = ".lock"
UNKNOWN = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)
"""What file systems answer that know no locks."""


class FolderHeld(OSError):
    """Another process holds the folder, or the file."""


class FolderLock:
    """The lock of `folder`, which must be there; FolderHeld where another process has it, OSError where it cannot be.
    `name` is that of the file in it that is locked.

    Where the system or its file system knows no locks, everybody gets one.
    """

    def __init__(self, folder: Path, name: str = LOCK) -> None:
        self.folder, self._known = folder, False
        path = folder / name
        refuse_links(path, folder)
        self._handle = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
        try:
            import fcntl
        except ImportError:
            return
        try:
            fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._known = True
        except OSError as error:
            if error.errno in UNKNOWN:
                return
            self.release()
            if isinstance(error, BlockingIOError):
                raise FolderHeld(error.errno, "another process holds it", str(folder)) from error
            raise

    @property
    def known(self) -> bool:
        """True if the system knows locks, so that who has one is the only one."""
        return self._known

    def release(self) -> None:
        """Let others have it."""
        handle, self._handle = self._handle, -1
        with contextlib.suppress(OSError):
            if handle >= 0:
                os.close(handle)


def file_lock(path: Path) -> FolderLock:
    """Return the lock of a file that may not be there yet: one beside it, for writing replaces the file itself."""
    real = Path(os.path.realpath(path))
    return FolderLock(real.parent, f".{real.name}{LOCK}")


def private_folder(prefix: str) -> FolderLock:
    """Return the lock of a new temporary folder of this user alone; those of processes that were killed are removed."""
    made = Path(tempfile.mkdtemp(prefix=prefix))
    lock = FolderLock(made)
    for left in made.parent.glob(f"{glob.escape(prefix)}*") if lock.known else ():
        with contextlib.suppress(OSError):
            # One without a lock may have been made a moment ago, by a process that is about to hold it.
            if left != made and (left / LOCK).is_file() and not left.is_symlink() and left.stat().st_uid == os.getuid():
                FolderLock(left).release()
                shutil.rmtree(left)
    return lock
