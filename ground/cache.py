"""The folder where a user's compiled models live.

`EXOID_CACHE` names another one. Where none can be trusted and written to, a private temporary folder serves.
"""

from __future__ import annotations

import os
import tempfile
from functools import lru_cache
from pathlib import Path


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
