"""The panel in which columns are named."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from exoid.apps.page.given import mapping_preview
from exoid.apps.page.reply import as_json, number_in
from exoid.ground.errors import RecordingError
from exoid.measurement.reading.mapping import StatedMapping
from exoid.measurement.reading.read import how_read

if TYPE_CHECKING:
    from exoid.apps.page.reply import Action, Answer
    from exoid.apps.page.workspace import Workspace


def _map(workspace: Workspace, told: dict[str, Any]) -> None:
    columns, units = ({str(k): str(v) for k, v in told[key].items() if v} for key in ("columns", "units"))
    before = workspace.find(int(told["file"])).told
    idle = told.get("passive", before.passive)
    said = StatedMapping(
        columns, units, str(told.get("leg", "")), str(told.get("convention", "")), passive=tuple(map(str, idle)),
        rate=_rate(told["rate"]) if "rate" in told else before.rate,
    )  # fmt: skip
    workspace.map_file(int(told["file"]), said)


def _rate(text: Any) -> float:
    """Return the Hz that were written beside a file without a clock, 0 where nothing was; RecordingError for others."""
    try:
        return how_read(rate=float(text or 0.0)).rate
    except ValueError as error:
        raise RecordingError(f"{str(text)[:20]!r} is no rate", remedy="give it in Hz: 100") from error


ANSWERS: dict[str, Answer] = {
    "columns": lambda workspace, request: as_json(
        mapping_preview(workspace.find(number_in(request, "file")), workspace.model.joints)
    ),
}
ACTIONS: dict[str, Action] = {"map": _map}
