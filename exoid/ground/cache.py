"""The folder where a user's compiled models live.

`EXOID_CACHE` names another one. What lies in it is run, so nobody else may be able to write there: not to the folder,
not to what lies in it, and not to a folder above it, where it could be exchanged. Where none can be trusted and
written to, a private temporary folder serves.
"""

from __future__ import annotations

import atexit
import errno
import os
import shutil
import stat
import sys
import tempfile
import warnings
from functools import lru_cache
from pathlib import Path

from platformdirs import user_cache_path

from exoid.ground.files import write_whole
from exoid.ground.inputs import read_input

if sys.platform != "win32":
    import grp
    import pwd

OTHERS = stat.S_IWGRP | stat.S_IWOTH


def cache_folder() -> Path:
    """Return the folder for compiled models, created if need be: EXOID_CACHE, the user's cache, or a
    private one.
    """
    wanted = os.environ.get("EXOID_CACHE")
    candidate = Path(wanted).expanduser() if wanted else user_cache_path("exoid", appauthor=False)
    try:
        why = _distrusted(candidate)
    except (OSError, ValueError, RuntimeError):  # a loop of links is a RuntimeError before Python 3.13
        return _private_folder()
    if why:
        _say_once(f"the cache {candidate} is not used: {why}; models are compiled anew by every command")
    return _private_folder() if why else candidate


def read_trusted(path: Path, most: int) -> bytes:
    """Return a file of the cache; OSError unless it is an ordinary file of at most `most` bytes that only this user
    can change, under its own name.
    """
    why = distrust(path)
    if why:
        raise OSError(errno.EPERM, why, str(path))
    return read_input(path, most, remember=False)


def write_trusted(path: Path, content: str) -> None:
    """Write a file of the cache that `read_trusted` reads, whatever the umask says; OSError where that cannot be."""
    write_whole(path, content, at_once=True, inside=path.parent)
    path.chmod(0o600)


def distrust(path: Path) -> str:
    """Reason why a file or folder of the cache is not to be trusted, "" where it is."""
    status = path.lstat()
    if not (stat.S_ISREG(status.st_mode) or stat.S_ISDIR(status.st_mode)):
        return f"{path} is neither a file nor a folder"
    if not hasattr(os, "getuid"):
        return ""
    if status.st_uid != os.getuid():
        return f"{path} belongs to somebody else"
    return f"others may write to {path}" if status.st_mode & OTHERS else ""


def _distrusted(folder: Path) -> str:
    """Reason why the folder is not to be trusted, "" where it is; OSError where it cannot be made or written to."""
    for part in reversed((folder, *folder.parents)):  # whatever the umask says of what is made above it
        part.mkdir(exist_ok=True, mode=0o700)
    real = folder.resolve(strict=True)
    with tempfile.TemporaryFile(dir=real):
        return distrust(real) or next(filter(None, map(_exchangeable, real.parents)), "")


def _exchangeable(folder: Path) -> str:
    """Reason why others could put another folder in the place of one below `folder`, "" where they cannot."""
    if not hasattr(os, "getuid"):
        return ""
    status = folder.stat()
    if status.st_uid not in (0, os.getuid()):
        return f"{folder} belongs to somebody else"
    open_to_all = status.st_mode & stat.S_IWOTH or (status.st_mode & stat.S_IWGRP and not _of_one(status.st_gid))
    # In a sticky folder such as /tmp everybody may write, but only the owner may rename.
    return f"others may write to {folder}" if open_to_all and not status.st_mode & stat.S_ISVTX else ""


def _of_one(group: int) -> bool:
    """True if the group is the user's own, with nobody else in it."""
    if sys.platform == "win32":
        return True
    try:
        user, found = pwd.getpwuid(os.getuid()).pw_name, grp.getgrgid(group)
    except KeyError:
        return False
    return found.gr_name == user and set(found.gr_mem) <= {user}


@lru_cache(maxsize=8)
def _say_once(text: str) -> None:
    warnings.warn(text, UserWarning, stacklevel=2)


@lru_cache(maxsize=1)
def _private_folder() -> Path:
    """Return a temporary folder of this process alone: nothing is kept, nothing can be planted."""
    folder = Path(tempfile.mkdtemp(prefix="exoid-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder
