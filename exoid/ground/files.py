"""Files written whole or not at all, and content hashes."""

from __future__ import annotations

import hashlib
from pathlib import Path

from exoid.ground.delivery import deliver
from exoid.ground.inputs import open_input

ROBOT_FILE = ".urdf"
MODEL_FILES = (".toml", ROBOT_FILE)
"""Suffixes of what may be given as a model."""


def write_whole(
    path: str | Path, content: str | bytes, *, at_once: bool = False, inside: Path | None = None
) -> Path:
    """Write `content` so that `path` holds either all of it or what it held before; return the path.

    Within `together()` it appears with the other files, unless `at_once`. OSError where it cannot be written, or is
    a file that was read. A pipe or a device is written into, a link followed; not so below the folder `inside`, where
    only files are replaced.
    """
    data = content.encode() if isinstance(content, str) else content
    return deliver(path, lambda stream: stream.write(data), at_once=at_once, inside=inside)


def sha256(content: str | bytes) -> str:
    """Return the SHA-256 of text or bytes as 64 hexadecimal digits."""
    return hashlib.sha256(content.encode() if isinstance(content, str) else content).hexdigest()


def sha256_file(path: str | Path) -> str:
    """Return the SHA-256 of a file's bytes."""
    with open_input(path, remember=False) as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
