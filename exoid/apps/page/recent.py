"""Folders of the sessions that were opened or saved last, kept in this user's cache for the start screen.

The list holds paths, which go to this user's own page and nowhere else.
"""

from __future__ import annotations

import contextlib
import json
import os
from pathlib import Path

from exoid.apps.page.folder import SESSION
from exoid.ground.cache import cache_folder, read_trusted, write_trusted
from exoid.ground.plain import SPOILT

FILE = "recent-sessions.json"
KEPT = 6
"""Sessions that the start screen offers."""
LARGEST = 100_000
"""Bytes of the list."""


def sessions() -> list[str]:
    """Folders of the last sessions that are still there, the newest first."""
    return [folder for folder in _noted() if os.path.isfile(os.path.join(folder, SESSION))]


def note(folder: Path) -> None:
    """Put a session first in the list; a list that cannot be written is no reason to stop."""
    _write([str(folder), *(other for other in _noted() if other != str(folder))][:KEPT])


def forget() -> None:
    """Empty the list."""
    _write([])


def _noted() -> list[str]:
    try:
        found = json.loads(read_trusted(cache_folder() / FILE, LARGEST))
    except (OSError, *SPOILT):
        return []
    return [folder for folder in found if isinstance(folder, str)] if isinstance(found, list) else []


def _write(folders: list[str]) -> None:
    with contextlib.suppress(OSError):
        write_trusted(cache_folder() / FILE, json.dumps(folders))
