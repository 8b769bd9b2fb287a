"""The model against the measurement: time series, and what explains the stretch that is chosen."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from exoid.apps.page import numbers
from exoid.apps.page.reply import as_bytes, number_in, text_in
from exoid.apps.page.workspace import Workspace, spans_of

if TYPE_CHECKING:
    from exoid.apps.page.reply import Action, Answer


def _brush(workspace: Workspace, told: dict[str, Any]) -> dict[str, Any]:
    joint = told.get("joint")
    found = numbers.explained(
        workspace, workspace.opened(), spans_of(told.get("spans", [])), None if joint is None else int(joint),
        told.get("box"),
    )  # fmt: skip
    return {"explained": found}


ANSWERS: dict[str, Answer] = {
    "motion": lambda workspace, request: as_bytes(
        numbers.motion_of(workspace.opened(), number_in(request, "recording"))
    ),
    "error": lambda workspace, request: as_bytes(
        numbers.error_of(workspace, workspace.opened(), number_in(request, "recording"))
    ),
    "preview": lambda workspace, request: as_bytes(
        numbers.preview_of(
            workspace, workspace.opened(), text_in(request, "effect"), number_in(request, "recording")
        )
    ),
    "answer": lambda workspace, request: as_bytes(
        numbers.other_error_of(workspace, workspace.opened(), number_in(request, "recording"))
    ),
    "column": lambda workspace, request: as_bytes(
        numbers.column_of(
            workspace, workspace.opened(), number_in(request, "recording"), text_in(request, "column")
        )
    ),
}
ACTIONS: dict[str, Action] = {"brush": _brush}
