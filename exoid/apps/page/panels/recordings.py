"""The files, and which of them are held out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from exoid.apps.page.given import shown_name
from exoid.measurement.reading.sources import OTHER_TYPES

if TYPE_CHECKING:
    from exoid.apps.page.reply import Action


ACTIONS: dict[str, Action] = {
    "close": lambda workspace, told: workspace.remove_file(int(told["file"])),
    "hold_out_last": lambda workspace, told: workspace.hold_out_last([int(id) for id in told["files"]]),
    "left_out": lambda workspace, told: workspace.leave_out(OTHER_TYPES, *map(shown_name, map(str, told["names"]))),
    "role": lambda workspace, told: workspace.use_as(int(told["file"]), str(told["role"])),
}
