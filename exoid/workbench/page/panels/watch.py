"""A recording that is played through a watch."""

from __future__ import annotations

from typing import TYPE_CHECKING

from exoid.workbench.page.reply import as_json

if TYPE_CHECKING:
    from exoid.workbench.page.reply import Action, Answer


ANSWERS: dict[str, Answer] = {
    "watch": lambda workspace, request: as_json(workspace.playing.whole() if workspace.playing else {}),
}
ACTIONS: dict[str, Action] = {"play": lambda workspace, told: workspace.play(int(told["recording"]))}
