"""Start screen: the demo, a session that was kept, or one of the last that were."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from exoid.apps.page import recent, saved
from exoid.apps.page.given import FIT
from exoid.apps.page.message import folder_in
from exoid.apps.page.reply import as_json
from exoid.ground.errors import RecordingError

if TYPE_CHECKING:
    from exoid.apps.page.reply import Action, Answer
    from exoid.apps.page.workspace import Workspace


def _demo(workspace: Workspace, told: dict[str, Any]) -> None:
    from exoid.workbench.commands.demo import DATA

    if workspace.given:
        raise RecordingError("recordings are open already", remedy="close them first, or open the demo in a new window")
    for role, pattern in ((FIT, "train*.csv"), ("verify", "verify*.csv")):
        for path in sorted(DATA.glob(pattern)):
            workspace.add_file(path, path.name, role)


def _reopen(workspace: Workspace, told: dict[str, Any]) -> None:
    if workspace.given:
        raise RecordingError("recordings are open already", remedy="close them first, or open the session by itself")
    if "drop" in told:
        saved.reopen(workspace, workspace.session_place(int(told["drop"]), "session.json").parent, kept=False)
    else:
        saved.reopen(workspace, folder_in(told))


def _forget(workspace: Workspace, told: dict[str, Any]) -> None:
    recent.forget()


ANSWERS: dict[str, Answer] = {"recent": lambda workspace, request: as_json({"folders": recent.sessions()})}
ACTIONS: dict[str, Action] = {"demo": _demo, "reopen": _reopen, "forget": _forget}
