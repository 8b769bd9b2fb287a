"""The suspected effects, and what is known of each."""

from __future__ import annotations

from typing import TYPE_CHECKING

from exoid.apps.page import views
from exoid.apps.page.reply import as_json, text_in

if TYPE_CHECKING:
    from exoid.apps.page.reply import Action, Answer


ANSWERS: dict[str, Answer] = {
    "details": lambda workspace, request: as_json(views.details(workspace, text_in(request, "effect"))),
}
ACTIONS: dict[str, Action] = {"add": lambda workspace, told: workspace.add(str(told["effect"]))}
