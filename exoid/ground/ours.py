"""Did exoid write this? A file is known by what stands at its beginning, one that cannot say so by its folder.

Names say nothing: a `model.toml`, `session.json` or `report.html` may be anybody's.
"""

from __future__ import annotations

import re
from pathlib import Path

HEAD = 4096
"""Bytes at the beginning of a file in which it says who wrote it."""
SIGNS = re.compile(
    rb'"schema"\s*:\s*"exoid\.|<title>[^<]*\bexoid\b[^<]*</title>|(?:[Ww]ritten|made) by `?exoid\b|tqdm/shtab'
)
"""What exoid writes there: the schema of its JSON, the title of its pages, a comment in code and model files, and what
shtab makes for a shell.
"""
WRITTEN_BY_HAND = (".toml",)
"""Files that people write themselves: these have to say that they are exoid's, whatever else is in the folder."""
WRITTEN = "Written by exoid"
"""What a comment says at the beginning of a file."""
OTHERS = "the {} there was not written by exoid, and would be lost"
"""Why a file of that name is not replaced."""


def says_so(path: Path) -> bool:
    """True if a file says at its beginning that exoid wrote it."""
    try:
        with path.open("rb") as stream:
            return SIGNS.search(stream.read(HEAD)) is not None
    except OSError:
        return False


def is_folder_of_ours(folder: Path) -> bool:
    """True if a file in `folder` says that exoid wrote it; a model file says nothing, it lies anywhere."""
    try:
        files = [path for path in folder.iterdir() if path.suffix not in WRITTEN_BY_HAND and path.is_file()]
    except OSError:
        return False
    return any(map(says_so, files))


def is_ours(path: Path, ours: bool) -> bool:
    """True if exoid wrote the file at `path`; `ours` says whether its folder is one of exoid's."""
    return says_so(path) or (ours and path.suffix not in WRITTEN_BY_HAND)
