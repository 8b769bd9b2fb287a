"""The effects that were added, one over the other."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from exoid.apps.page.reply import Action


ACTIONS: dict[str, Action] = {
    "remove": lambda workspace, told: workspace.change_history(lambda history: history.remove(str(told["effect"]))),
    "switch": lambda workspace, told: workspace.change_history(lambda history: history.switch(str(told["effect"]))),
}
