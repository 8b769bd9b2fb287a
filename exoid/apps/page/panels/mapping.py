"""Which column is which."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from exoid.apps.page.given import mapping_preview
from exoid.apps.page.reply import as_json, number_in
from exoid.measurement.reading.mapping import StatedMapping

if TYPE_CHECKING:
    from exoid.apps.page.reply import Action, Answer
    from exoid.apps.page.workspace import Workspace


def _map(workspace: Workspace, told: dict[str, Any]) -> None:
    columns, units = ({str(k): str(v) for k, v in told[key].items() if v} for key in ("columns", "units"))
    idle = told.get("passive", workspace.find(int(told["file"])).told.passive)
    said = StatedMapping(
        columns, units, str(told.get("leg", "")), str(told.get("convention", "")), passive=tuple(map(str, idle))
    )
    workspace.map_file(int(told["file"]), said)


ANSWERS: dict[str, Answer] = {
    "columns": lambda workspace, request: as_json(
        mapping_preview(workspace.find(number_in(request, "file")), workspace.model.joints)
    ),
}
ACTIONS: dict[str, Action] = {"map": _map}
