"""Results to take away: report, model, code, commands, the session."""

from __future__ import annotations

from typing import TYPE_CHECKING

from exoid.apps.page import saved, takeaway
from exoid.apps.page.message import folder_in
from exoid.apps.page.reply import as_file, as_json, text_in

if TYPE_CHECKING:
    from exoid.apps.page.reply import Action, Answer


ANSWERS: dict[str, Answer] = {
    "takeaway": lambda workspace, request: as_json(takeaway.commands(workspace)),
    "report": lambda workspace, request: as_file(takeaway.report(workspace), takeaway.REPORT, "text/html"),
    "model": lambda workspace, request: as_file(takeaway.model_toml(workspace), takeaway.MODEL, "text/plain"),
    "export": lambda workspace, request: as_file(
        takeaway.exported(workspace, text_in(request, "format")), "exoid-model.zip", "application/zip"
    ),
}
ACTIONS: dict[str, Action] = {
    "save": lambda workspace, told: {"folder": str(saved.save(workspace, folder_in(told)))},
}
