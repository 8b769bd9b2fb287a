"""The local server: every address of the page, and what it asks the workspace."""

from __future__ import annotations

import shutil
from collections.abc import AsyncIterator, Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anyio.to_thread
from starlette.applications import Starlette
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response, StreamingResponse
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from exoid.ground.errors import ExoidError, RecordingError
from exoid.measurement.reading.limits import MOST_BYTES
from exoid.measurement.reading.mapping import FILE as MAPPING
from exoid.measurement.reading.sources import is_recording
from exoid.workbench.page import numbers, saved, takeaway, views
from exoid.workbench.page.given import FIT, error_json, internal, mapping_preview, shown_name
from exoid.workbench.page.guard import Guard
from exoid.workbench.page.message import LONGEST, RELOAD, folder_in, obey, read_message

if TYPE_CHECKING:
    from starlette.requests import Request

    from exoid.workbench.page.workspace import Workspace

STATIC = Path(__file__).parent / "static"
REPORT_STYLE = Path(__file__).parent.parent / "report" / "page.css"
BEAT = 10.0
"""Seconds after which an open connection says that it is still there."""


def application(workspace: Workspace, token: str, port: int) -> Guard:
    """Return the guarded application."""

    routes = [
        Route("/", lambda request: FileResponse(STATIC / "index.html")),
        Route("/report.css", lambda request: FileResponse(REPORT_STYLE)),
        Route("/api/events", partial(_events, workspace)),
        *(Route(f"/api/{name}", partial(ask, workspace)) for name, ask in ANSWERS.items()),
        Route("/api/file", partial(_upload, workspace), methods=["PUT"]),
        Route("/api/session", partial(_upload_session, workspace), methods=["PUT"]),
        *(Route(f"/api/{name}", _told(workspace, name, do), methods=["POST"]) for name, do in ACTIONS.items()),
        Mount("/static", StaticFiles(directory=STATIC)),
    ]
    handlers: dict[Any, Any] = {ExoidError: _refused, OSError: _refused, Exception: _broken}
    return Guard(Starlette(routes=routes, exception_handlers=handlers), token, port)


# -- what is asked -------------------------------------------------------------------------------------------------


def _preview(workspace: Workspace, request: Request) -> Response:
    name = request.query_params.get("effect", "")
    return _bytes(numbers.preview_of(workspace, workspace.opened(), name, _number(request, "recording")))


def _export(workspace: Workspace, request: Request) -> Response:
    archive = takeaway.exported(workspace, request.query_params.get("format", ""))
    headers = {"content-disposition": 'attachment; filename="exoid-model.zip"'}
    return Response(archive, media_type="application/zip", headers=headers)


ANSWERS: dict[str, Callable[[Workspace, Request], Response]] = {
    "state": lambda workspace, request: JSONResponse(views.state(workspace)),
    "details": lambda workspace, request: JSONResponse(
        views.details(workspace, request.query_params.get("effect", ""))
    ),
    "motion": lambda workspace, request: _bytes(numbers.motion_of(workspace.opened(), _number(request, "recording"))),
    "error": lambda workspace, request: _bytes(
        numbers.error_of(workspace, workspace.opened(), _number(request, "recording"))
    ),
    "preview": _preview,
    "strides": lambda workspace, request: JSONResponse(numbers.strides(workspace, workspace.opened())),
    "answer": lambda workspace, request: _bytes(
        numbers.other_error_of(workspace, workspace.opened(), _number(request, "recording"))
    ),
    "column": lambda workspace, request: _bytes(
        numbers.column_of(
            workspace, workspace.opened(), _number(request, "recording"), request.query_params.get("column", "")
        )
    ),
    "columns": lambda workspace, request: JSONResponse(
        mapping_preview(workspace.find(_number(request, "file")), workspace.model.joints)
    ),
    "takeaway": lambda workspace, request: JSONResponse(takeaway.commands(workspace)),
    "watch": lambda workspace, request: JSONResponse(workspace.playing.whole() if workspace.playing else {}),
    "report": lambda workspace, request: _download(takeaway.report(workspace), takeaway.REPORT, "text/html"),
    "model": lambda workspace, request: _download(takeaway.model_toml(workspace), takeaway.MODEL, "text/plain"),
    "export": _export,
}
"""What the page asks for."""


# -- what is done --------------------------------------------------------------------------------------------------


def _demo(workspace: Workspace, told: dict[str, Any]) -> None:
    from exoid.workbench.commands.demo import DATA

    if workspace.given:
        raise RecordingError("recordings are open already", remedy="close them first, or open the demo in a new window")
    for role, pattern in ((FIT, "train*.csv"), ("verify", "verify*.csv")):
        for path in sorted(DATA.glob(pattern)):
            workspace.add_file(path, path.name, role)


def _map(workspace: Workspace, told: dict[str, Any]) -> None:
    from exoid.measurement.reading.mapping import StatedMapping

    columns, units = ({str(k): str(v) for k, v in told[key].items() if v} for key in ("columns", "units"))
    idle = told.get("passive", workspace.find(int(told["file"])).told.passive)
    said = StatedMapping(
        columns, units, str(told.get("leg", "")), str(told.get("convention", "")), passive=tuple(map(str, idle))
    )
    workspace.map_file(int(told["file"]), said)


def _read_as(workspace: Workspace, told: dict[str, Any]) -> None:
    """Read all files, or the one that is named, in another convention."""
    for one in [one for one in workspace.given if told.get("file") in (None, one.name)]:
        workspace.map_file(one.id, replace(one.told, convention=str(told["convention"])))


def _brush(workspace: Workspace, told: dict[str, Any]) -> dict[str, Any]:
    from exoid.workbench.page.workspace import spans_of

    joint = told.get("joint")
    found = numbers.explained(
        workspace, workspace.opened(), spans_of(told.get("spans", [])), None if joint is None else int(joint),
        told.get("box"),
    )  # fmt: skip
    return {"explained": found}


def _reopen(workspace: Workspace, told: dict[str, Any]) -> None:
    if workspace.given:
        raise RecordingError("recordings are open already", remedy="close them first, or open the session by itself")
    if "drop" in told:
        saved.reopen(workspace, workspace.session_place(int(told["drop"]), "session.json").parent, kept=False)
    else:
        saved.reopen(workspace, folder_in(told))


def _auto(workspace: Workspace, told: dict[str, Any]) -> None:
    with workspace.change:
        workspace.judging.switch(bool(told["on"]))
    workspace.touch()


ACTIONS: dict[str, Callable[[Workspace, dict[str, Any]], Any]] = {
    "add": lambda workspace, told: workspace.add(str(told["effect"])),
    "auto": _auto,
    "brush": _brush,
    "cancel": lambda workspace, told: workspace.cancel(),
    "close": lambda workspace, told: workspace.remove_file(int(told["file"])),
    "demo": _demo,
    "discover": lambda workspace, told: workspace.discover(),
    "effect": lambda workspace, told: workspace.add_effect(dict(told["effect"])),
    "go": lambda workspace, told: workspace.change_history(lambda history: history.go(int(told["at"]))),
    "map": _map,
    "play": lambda workspace, told: workspace.play(int(told["recording"])),
    "read_as": _read_as,
    "redo": lambda workspace, told: workspace.change_history(lambda history: history.redo()),
    "remove": lambda workspace, told: workspace.change_history(lambda history: history.remove(str(told["effect"]))),
    "reopen": _reopen,
    "role": lambda workspace, told: workspace.use_as(int(told["file"]), str(told["role"])),
    "save": lambda workspace, told: {"folder": str(saved.save(workspace, folder_in(told)))},
    "switch": lambda workspace, told: workspace.change_history(lambda history: history.switch(str(told["effect"]))),
    "undo": lambda workspace, told: workspace.change_history(lambda history: history.undo()),
}
"""What the page may ask to be done, with what it says of it; a dict that comes back is the answer."""


async def _upload(workspace: Workspace, request: Request) -> Response:
    """Take in a file that was dropped: a recording, a model, or what `exoid map` keeps. Of a folder only these."""
    name, role = request.query_params.get("name", ""), request.query_params.get("role", FIT)
    target = workspace.drop_place(name)
    await _written(request, target)

    def take() -> dict[str, Any]:
        if target.name == MAPPING:
            workspace.use_mapping(target)
        elif target.suffix == ".toml":
            workspace.use_model(target, name)
        elif "folder" in request.query_params and not is_recording(target):
            target.unlink()
            return {"passed_over": shown_name(name)}
        else:
            return {"id": workspace.add_file(target, name, role).id}
        return {}

    return JSONResponse(await anyio.to_thread.run_sync(take))


async def _upload_session(workspace: Workspace, request: Request) -> Response:
    """Take in one file of the folder of a session that was dropped; `reopen` opens it when all are here."""
    drop = _number(request, "drop")
    await _written(request, workspace.session_place(drop, request.query_params.get("name", "")))
    return JSONResponse({})


async def _written(request: Request, target: Path) -> None:
    """Write what is sent; RecordingError for more than half of what the disk has left."""
    room = min(MOST_BYTES, shutil.disk_usage(target.parent).free // 2)
    async with await anyio.open_file(target, "wb") as file:
        async for part in request.stream():
            room -= len(part)
            if room < 0:
                await anyio.Path(target).unlink()
                raise RecordingError("the file is too large to be dropped", remedy="name it on the command line")
            await file.write(part)


async def _events(workspace: Workspace, request: Request) -> Response:
    """Tell the number of the present version whenever there is a new one."""

    async def lines() -> AsyncIterator[str]:
        waiting = anyio.CapacityLimiter(1)  # of its own: waiting tabs take no thread from those that ask
        version = -1
        while not workspace.closed:
            version = await anyio.to_thread.run_sync(
                workspace.wait, version, BEAT, abandon_on_cancel=True, limiter=waiting
            )
            yield f"data: {version}\n\n"

    return StreamingResponse(lines(), media_type="text/event-stream")


# -- how it is answered --------------------------------------------------------------------------------------------


def _told(
    workspace: Workspace, action: str, do: Callable[[Workspace, dict[str, Any]], Any]
) -> Callable[[Request], Any]:
    async def endpoint(request: Request) -> Response:
        body = bytearray()
        async for part in request.stream():
            body += part
            if len(body) > LONGEST:
                raise RecordingError("the message is too long", remedy=RELOAD)
        told = read_message(bytes(body))
        return JSONResponse(await anyio.to_thread.run_sync(obey, workspace, action, do, told))

    return endpoint


def _refused(request: Request, error: Exception) -> Response:
    # A refusal is an answer like another: as a status of HTTP it would be an error in the browser's console.
    said = error if isinstance(error, ExoidError) else ExoidError(str(getattr(error, "strerror", None) or error))
    return JSONResponse({"refused": error_json(said)})


def _broken(request: Request, error: Exception) -> Response:
    return JSONResponse(error_json(internal(error)), status_code=500)


def _number(request: Request, name: str) -> int:
    text = request.query_params.get(name, "")
    if not text.isdecimal() or len(text) > 9:
        raise RecordingError(f"{name} is no number", remedy=RELOAD)
    return int(text)


def _bytes(content: bytes) -> Response:
    return Response(content, media_type="application/octet-stream")


def _download(text: str, name: str, kind: str) -> Response:
    return PlainTextResponse(text, media_type=kind, headers={"content-disposition": f'attachment; filename="{name}"'})
