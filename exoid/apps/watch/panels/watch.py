"""A recording that is played through a watch. The page reads this module as it reads its own panels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from exoid.ground.errors import RecordingError

NAME = "watch"


def _played(workspace: Any, request: Any) -> dict[str, Any]:
    playing = workspace.tasks.get(NAME)
    return {} if playing is None else playing.whole()


def _play(workspace: Any, told: dict[str, Any]) -> None:
    """Play a recording through a watch of the present model, in a thread of its own."""
    from exoid.apps.watch.playing import BackgroundWatch

    index = int(told["recording"])
    with workspace.change:
        session, names = workspace.opened(), workspace.names
        recordings = [*session.recordings, *session.verify]
        if not 0 <= index < len(recordings):
            raise RecordingError("this recording is not open any more", remedy="reload the page")
        now = session.known(names) or session.fitted()
        workspace.start(
            NAME, BackgroundWatch(now.model, recordings[index], index, session.extra, workspace.touch)
        )


ANSWERS: Mapping[str, Callable[[Any, Any], dict[str, Any]]] = MappingProxyType({NAME: _played})
ACTIONS: Mapping[str, Callable[[Any, dict[str, Any]], None]] = MappingProxyType({"play": _play})
