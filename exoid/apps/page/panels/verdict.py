"""The answer, the search for it, and the steps back and forth."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from exoid.apps.page.reply import Action
    from exoid.apps.page.workspace import Workspace


def _auto(workspace: Workspace, told: dict[str, Any]) -> None:
    with workspace.change:
        workspace.judging.switch(bool(told["on"]))
    workspace.touch()


def _read_as(workspace: Workspace, told: dict[str, Any]) -> None:
    """Read all files, or the one that is named, in another convention."""
    for item in [entry for entry in workspace.given if told.get("file") in (None, entry.name)]:
        workspace.map_file(item.id, replace(item.told, convention=str(told["convention"])))


ACTIONS: dict[str, Action] = {
    "auto": _auto,
    "cancel": lambda workspace, told: workspace.cancel(),
    "discover": lambda workspace, told: workspace.discover(),
    "go": lambda workspace, told: workspace.change_history(lambda history: history.go(int(told["at"]))),
    "read_as": _read_as,
    "redo": lambda workspace, told: workspace.change_history(lambda history: history.redo()),
    "undo": lambda workspace, told: workspace.change_history(lambda history: history.undo()),
}
