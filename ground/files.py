"""Files written whole or not at all, their content hashes, and the folder where a user's compiled models
live.

`EXOID_CACHE` names another folder. Where the home folder cannot be written to, a private temporary folder
serves.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import IO


def write_whole(path: str | Path, content: str | bytes) -> Path:
    """Write `content` so that `path` holds either all of it or what it held before; return the path."""
    data = content.encode() if isinstance(content, str) else content
    return write_whole_with(path, lambda stream: _write(stream, data))


def write_whole_with(path: str | Path, write: Callable[[IO[bytes]], None]) -> Path:
    """Let `write(stream)` fill a temporary neighbour of `path`, then put it in place in one step."""
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
    try:
        with os.fdopen(handle, "wb") as stream:
            write(stream)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(name, 0o666 & ~_umask())
        os.replace(name, target)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
    return target


def sha256(content: str | bytes) -> str:
    """Return the SHA-256 of text or bytes as 64 hexadecimal digits."""
    return hashlib.sha256(content.encode() if isinstance(content, str) else content).hexdigest()


def sha256_file(path: str | Path) -> str:
    """Return the SHA-256 of a file's bytes."""
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def cache_folder() -> Path:
    """Return the folder for compiled models, created if need be: EXOID_CACHE, the user's cache, or a
    private one.
    """
    wanted = os.environ.get("EXOID_CACHE")
    if wanted:
        candidates = [Path(wanted).expanduser()]
    else:
        import platformdirs

        candidates = [Path(platformdirs.user_cache_dir("exoid", appauthor=False))]
    for candidate in candidates:
        if _is_ours(candidate):
            return candidate
    return _private_folder()


def _is_ours(folder: Path) -> bool:
    """Whether the folder can be created and written to, and nobody else owns it: it holds code that will be
    run.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        if hasattr(os, "getuid") and folder.stat().st_uid != os.getuid():
            return False
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


@lru_cache(maxsize=1)
def _private_folder() -> Path:
    """Return a temporary folder of this process alone: nothing is kept, nothing can be planted."""
    import atexit
    import shutil

    folder = Path(tempfile.mkdtemp(prefix="exoid-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def _write(stream: IO[bytes], data: bytes) -> None:
    stream.write(data)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
