"""Places that modules are imported from: never the current folder, in which recordings of somebody else may lie.

Python puts that folder first on the path of whatever is started with -m or -c, workers among them, and an empty or
relative entry of PYTHONPATH means it too. A `socket.py` beside the recordings would then be run.
"""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path

SAFE = "PYTHONSAFEPATH"
"""Set, Python puts neither the current folder nor that of a script on the path."""
PATH = "PYTHONPATH"
HOME = str(Path(str(sys.modules[__name__.partition(".")[0]].__file__)).resolve().parents[1])
"""The folder in which exoid lies."""


def leave_out_current_folder() -> None:
    """Take what means the current folder, whichever that is, out of the path of this process and of all it starts."""
    os.environ[SAFE] = "1"
    given = os.environ.get(PATH, "").split(os.pathsep)
    kept = [entry for entry in given if not _is_here(entry)]
    if kept != given:
        here = {os.path.abspath(entry) for entry in given if _is_here(entry)} - {os.path.abspath(item) for item in kept}
        sys.path[:] = [entry for entry in sys.path if entry not in here or entry == HOME]
        os.environ[PATH] = os.pathsep.join(kept)
        if not kept:
            del os.environ[PATH]
    sys.path[:] = [entry for entry in sys.path if entry]


def environment_of_workers() -> dict[str, str]:
    """Environment of a process that is to import what this one does."""
    path = [entry for entry in sys.path if entry]
    return {SAFE: "1", PATH: os.pathsep.join(path if HOME in path else [*path, HOME])}


@contextlib.contextmanager
def workers_import_alike(**more: str) -> Iterator[None]:
    """Give every process that a library starts inside the environment of workers, and `more` of it."""
    wanted = environment_of_workers() | more
    before = {name: os.environ.get(name) for name in wanted}
    os.environ.update(wanted)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _is_here(entry: str) -> bool:
    """True if an entry of PYTHONPATH means the current folder, whichever that is."""
    return os.path.normpath(entry or os.curdir) == os.curdir
