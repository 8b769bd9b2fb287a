"""Messages of the page: short, shallow, of finite numbers, and from a page that has seen the steps it speaks of."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from exoid.ground.errors import RecordingError, refused
from exoid.ground.plain import SPOILT

if TYPE_CHECKING:
    from exoid.apps.page.workspace import Workspace

LONGEST = 1_000_000
"""Bytes of a message; files are no messages."""
DEEPEST = 16
"""Lists and objects within one another; a box in a plane has two."""
STEPS = ("add", "go", "redo", "remove", "switch", "undo")
"""Actions whose meaning depends on the steps that the page shows."""
RELOAD = "reload the page"


def read_message(body: bytes) -> dict[str, Any]:
    """Return the object in a message; RecordingError for anything else."""
    try:
        told = json.loads(body or b"{}", parse_constant=_finite, parse_float=_finite)
    except RecursionError as error:
        raise RecordingError("the message is nested too deeply", remedy=RELOAD) from error
    except ValueError as error:
        raise RecordingError(f"the message cannot be understood ({error})", remedy=RELOAD) from error
    if not isinstance(told, dict):
        raise RecordingError("the message is no object", remedy=RELOAD)
    if not _shallow(told, DEEPEST):
        raise RecordingError("the message is nested too deeply", remedy=RELOAD)
    return told


def obey(
    workspace: Workspace, action: str, do: Callable[[Workspace, dict[str, Any]], Any], told: dict[str, Any]
) -> dict[str, Any]:
    """Do what a message asks for and return the answer.

    RecordingError where the message does not say what it should, or comes from a page that has not seen yet which steps
    another page has made.
    """
    try:
        if action not in STEPS:
            found = do(workspace, told)
        else:
            page, seen = str(told.get("page", "")), told.get("seen")
            with workspace.change:
                if seen is not None and any(other != page for other in workspace.edits[max(0, int(seen)) :]):
                    what = "the steps were changed elsewhere meanwhile, and nothing was done"
                    remedy = "look at them as they are now, which this page shows, and do it again"
                    raise RecordingError(what, remedy=remedy)
                found = do(workspace, told)
                workspace.edits.append(page)
    except SPOILT as error:
        raise RecordingError(f"the message cannot be understood ({str(error)[:200]})", remedy=RELOAD) from error
    return found if isinstance(found, dict) else {}


def folder_in(told: dict[str, Any]) -> Path:
    """Return the folder that a message names; RecordingError where it names none."""
    name = told["folder"]
    if not isinstance(name, str) or not name.strip():
        raise RecordingError("this names no folder", remedy="write the path of one")
    with refused(RecordingError, "the folder cannot be found ({})", name[:200], "write its path", (RuntimeError,)):
        return Path(name).expanduser()


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text[:20]} is not finite")
    return value


def _shallow(value: Any, deepest: int) -> bool:
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return deepest > 0 and all(_shallow(item, deepest - 1) for item in inner)
