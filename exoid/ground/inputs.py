"""Files from outside: opened only where they are ordinary files, so that a pipe or a device cannot make exoid wait
for ever, and remembered, so that nothing is written over them.
"""

from __future__ import annotations

import errno
import os
import stat
from io import BufferedReader
from pathlib import Path

from exoid.ground.delivery import current
from exoid.ground.inside import refuse_links


def open_input(path: str | Path, *, remember: bool = True, inside: str | Path | None = None) -> BufferedReader:
    """Return an ordinary file open for reading; OSError for anything else, without waiting.

    Without `remember` it may be written to afterwards: it is a file of exoid's own. Below the folder `inside` no link
    is followed.
    """
    if inside is not None:
        refuse_links(path, inside)
    # Not to be waited for: a pipe would block here until somebody writes into it.
    how = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    try:
        handle = os.open(path, how if inside is None else how | getattr(os, "O_NOFOLLOW", 0))
    except ValueError as error:
        raise OSError(errno.EINVAL, "this is not a path of a file", str(path)) from error
    try:
        status = os.fstat(handle)
        if stat.S_ISDIR(status.st_mode):
            raise IsADirectoryError(errno.EISDIR, "this is a folder", str(path))
        if not stat.S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, "this is not an ordinary file", str(path))
        delivery = current()
        if delivery is not None and remember:
            delivery.note(status, path)
        return os.fdopen(handle, "rb")
    except BaseException:
        os.close(handle)
        raise


def read_input(path: str | Path, most: int, *, remember: bool = True, inside: str | Path | None = None) -> bytes:
    """Return the content of an ordinary file of at most `most` bytes; OSError for anything else or larger."""
    with open_input(path, remember=remember, inside=inside) as stream:
        data = stream.read(most + 1)
    if len(data) > most:
        raise OSError(errno.EFBIG, f"it is larger than {most / 1e6:g} MB", str(path))
    return data
