"""Folders that exoid writes into, or that somebody else handed on: no link in them leads exoid elsewhere, and it opens
nothing in them but ordinary files.

The folder itself may be reached by links: whoever named it meant where they lead.
"""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path


def is_inside(path: str | Path, folder: str | Path) -> bool:
    """True if `path`, as it is written, lies below `folder`."""
    return Path(os.path.abspath(folder)) in Path(os.path.abspath(path)).parents


def refuse_links(path: str | Path, folder: str | Path) -> None:
    """Raise OSError where `path` does not lie below `folder`, where one of its parts below it is a link, or where it is
    anything but a file or a folder; what is not there yet passes.
    """
    if not is_inside(path, folder):
        raise OSError(errno.EPERM, f"it lies outside of {folder}", str(path))
    place = Path(os.path.abspath(folder))
    for part in Path(os.path.abspath(path)).relative_to(place).parts:
        place /= part
        try:
            kind = os.lstat(place).st_mode
        except (FileNotFoundError, NotADirectoryError):
            return
        except ValueError as error:
            raise OSError(errno.EINVAL, "this is not a path of a file", str(path)) from error
        if stat.S_ISLNK(kind):
            what = f"it is a link, and inside of {folder} none is followed; remove it, or put the file in its place"
            raise OSError(errno.ELOOP, what, str(place))
        if not (stat.S_ISREG(kind) or stat.S_ISDIR(kind)):
            raise OSError(errno.EINVAL, "this is not an ordinary file", str(place))
