"""The files, and which of them are held out."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from exoid.apps.page.reply import Action


ACTIONS: dict[str, Action] = {
    "close": lambda workspace, told: workspace.remove_file(int(told["file"])),
    "role": lambda workspace, told: workspace.use_as(int(told["file"]), str(told["role"])),
}
