"""The local server: every address of the page, and what it asks the workspace."""

from __future__ import annotations

import json
import traceback
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anyio.to_thread
from starlette.applications import Starlette
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response, StreamingResponse
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from ground.errors import ExoidError, RecordingError
from ground.text import printable
from workbench.page.given import FIT, error_json
from workbench.page.guard import Guard

if TYPE_CHECKING:
    from starlette.requests import Request

    from workbench.page.workspace import Workspace

STATIC = Path(__file__).parent / "static"
REPORT_STYLE = Path(__file__).parent.parent / "report" / "page.css"
MOST_MESSAGE = 1_000_000
"""Bytes of a message of the page; files are not messages."""
BEAT = 10.0
"""Seconds after which an open connection says that it is still there."""


def application(workspace: Workspace, token: str, port: int) -> Guard:
    """Return the guarded application."""

    def ask(answer: Callable[[Workspace, Request], Response]) -> Callable[[Request], Response]:
        return _asked(workspace, answer)

    routes = [
        Route("/", lambda request: FileResponse(STATIC / "index.html")),
        Route("/report.css", lambda request: FileResponse(REPORT_STYLE)),
        Route("/api/state", ask(_state)),
        Route("/api/events", _served(workspace, _events)),
        Route("/api/details", ask(_details)),
        Route("/api/motion", ask(_motion)),
        Route("/api/error", ask(_error)),
        Route("/api/preview", ask(_preview)),
        Route("/api/columns", ask(_columns)),
        Route("/api/takeaway", ask(_takeaway)),
        Route("/api/watch", ask(_watch)),
        Route("/api/report", ask(_report)),
        Route("/api/model", ask(_model)),
        Route("/api/export", ask(_export)),
        Route("/api/file", _served(workspace, _upload), methods=["PUT"]),
        Route("/api/session", _served(workspace, _upload_session), methods=["PUT"]),
        *(Route(f"/api/{name}", _told(workspace, do), methods=["POST"]) for name, do in ACTIONS.items()),
        Mount("/static", StaticFiles(directory=STATIC)),
    ]
    return Guard(Starlette(routes=routes), token, port)


# -- what is asked -------------------------------------------------------------------------------------------------


def _state(workspace: Workspace, request: Request) -> Response:
    from workbench.page.views import state

    return JSONResponse(state(workspace))


def _details(workspace: Workspace, request: Request) -> Response:
    from workbench.page.views import details

    return JSONResponse(details(workspace, request.query_params.get("effect", "")))


def _motion(workspace: Workspace, request: Request) -> Response:
    from workbench.page.numbers import motion_of

    return _bytes(motion_of(_session(workspace), _number(request, "recording")))


def _error(workspace: Workspace, request: Request) -> Response:
    from workbench.page.numbers import error_of

    return _bytes(error_of(workspace, _session(workspace), _number(request, "recording")))


def _preview(workspace: Workspace, request: Request) -> Response:
    from workbench.page.numbers import preview_of

    name = request.query_params.get("effect", "")
    return _bytes(preview_of(workspace, _session(workspace), name, _number(request, "recording")))


def _columns(workspace: Workspace, request: Request) -> Response:
    from workbench.page.given import mapping_preview

    return JSONResponse(mapping_preview(workspace.find(_number(request, "file")), workspace.model.joints))


def _takeaway(workspace: Workspace, request: Request) -> Response:
    from workbench.page.takeaway import commands

    return JSONResponse(commands(workspace))


def _watch(workspace: Workspace, request: Request) -> Response:
    return JSONResponse({} if workspace.playing is None else workspace.playing.whole())


def _report(workspace: Workspace, request: Request) -> Response:
    from workbench.page.takeaway import REPORT, report

    return _download(report(workspace), REPORT, "text/html")


def _model(workspace: Workspace, request: Request) -> Response:
    from workbench.page.takeaway import MODEL, model_toml

    return _download(model_toml(workspace), MODEL, "text/plain")


def _export(workspace: Workspace, request: Request) -> Response:
    from workbench.page.takeaway import exported

    return Response(
        exported(workspace, request.query_params.get("format", "")),
        media_type="application/zip",
        headers={"content-disposition": 'attachment; filename="exoid-model.zip"'},
    )


# -- what is done --------------------------------------------------------------------------------------------------


def _demo(workspace: Workspace, told: dict[str, Any]) -> None:
    from workbench.commands.demo import DATA

    if workspace.given:
        raise RecordingError("recordings are open already", remedy="close them first, or open the demo in a new window")
    for role, pattern in ((FIT, "train*.csv"), ("verify", "verify*.csv")):
        for path in sorted(DATA.glob(pattern)):
            workspace.add_file(path, path.name, role)


def _add(workspace: Workspace, told: dict[str, Any]) -> None:
    workspace.add(str(told["effect"]))


def _switch(workspace: Workspace, told: dict[str, Any]) -> None:
    workspace.change_history(lambda history: history.switch(str(told["effect"])))


def _remove(workspace: Workspace, told: dict[str, Any]) -> None:
    workspace.change_history(lambda history: history.remove(str(told["effect"])))


def _undo(workspace: Workspace, told: dict[str, Any]) -> None:
    workspace.change_history(lambda history: history.undo())


def _redo(workspace: Workspace, told: dict[str, Any]) -> None:
    workspace.change_history(lambda history: history.redo())


def _go(workspace: Workspace, told: dict[str, Any]) -> None:
    workspace.change_history(lambda history: history.go(int(told["at"])))


def _discover(workspace: Workspace, told: dict[str, Any]) -> None:
    workspace.discover()


def _play(workspace: Workspace, told: dict[str, Any]) -> None:
    workspace.play(int(told["recording"]))


def _cancel(workspace: Workspace, told: dict[str, Any]) -> None:
    workspace.cancel()


def _role(workspace: Workspace, told: dict[str, Any]) -> None:
    workspace.use_as(int(told["file"]), str(told["role"]))


def _close(workspace: Workspace, told: dict[str, Any]) -> None:
    workspace.remove_file(int(told["file"]))


def _map(workspace: Workspace, told: dict[str, Any]) -> None:
    from measurement.reading.mapping import StatedMapping

    columns, units = ({str(k): str(v) for k, v in told[key].items() if v} for key in ("columns", "units"))
    said = StatedMapping(columns, units, str(told.get("leg", "")))
    workspace.map_file(int(told["file"]), said, str(told.get("convention", "")))


def _effect(workspace: Workspace, told: dict[str, Any]) -> None:
    workspace.add_effect(dict(told["effect"]))


def _brush(workspace: Workspace, told: dict[str, Any]) -> dict[str, Any]:
    from workbench.page.numbers import explained
    from workbench.page.workspace import spans_of

    joint = told.get("joint")
    found = explained(
        workspace, _session(workspace), spans_of(told.get("spans", [])), None if joint is None else int(joint),
        told.get("box"),
    )  # fmt: skip
    return {"explained": found}


def _save(workspace: Workspace, told: dict[str, Any]) -> dict[str, Any]:
    from workbench.page.takeaway import save

    return {"folder": str(save(workspace, Path(str(told["folder"]))))}


def _reopen(workspace: Workspace, told: dict[str, Any]) -> None:
    from workbench.page.takeaway import reopen

    if workspace.given:
        raise RecordingError("recordings are open already", remedy="close them first, or open the session by itself")
    if "drop" in told:
        reopen(workspace, workspace.session_place(int(told["drop"]), "session.json").parent, kept=False)
    else:
        reopen(workspace, Path(str(told["folder"])).expanduser())


ACTIONS: dict[str, Callable[[Workspace, dict[str, Any]], dict[str, Any] | None]] = {
    "demo": _demo, "add": _add, "switch": _switch, "remove": _remove, "undo": _undo, "redo": _redo, "go": _go,
    "discover": _discover, "cancel": _cancel, "role": _role, "close": _close, "map": _map, "effect": _effect,
    "brush": _brush, "save": _save, "reopen": _reopen, "play": _play,
}  # fmt: skip


async def _upload(workspace: Workspace, request: Request) -> Response:
    """Take in a file that was dropped: a recording, or a model file."""
    name = request.query_params.get("name", "")
    target = workspace.drop_place(name)
    try:
        await _written(request, target)
        take = workspace.use_model if target.suffix == ".toml" else workspace.add_file
        role = () if target.suffix == ".toml" else (request.query_params.get("role", FIT),)
        await anyio.to_thread.run_sync(lambda: take(target, name, *role))
    except (ExoidError, OSError) as error:
        return _problem(error)
    return JSONResponse({})


async def _upload_session(workspace: Workspace, request: Request) -> Response:
    """Take in one file of the folder of a session that was dropped; `reopen` opens it when all are here."""
    try:
        drop = _number(request, "drop")
        await _written(request, workspace.session_place(drop, request.query_params.get("name", "")))
    except (ExoidError, OSError) as error:
        return _problem(error)
    return JSONResponse({})


async def _written(request: Request, target: Path) -> None:
    async with await anyio.open_file(target, "wb") as file:
        async for part in request.stream():
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


def _asked(workspace: Workspace, ask: Callable[[Workspace, Request], Response]) -> Callable[[Request], Response]:
    def endpoint(request: Request) -> Response:
        try:
            return ask(workspace, request)
        except Exception as error:  # noqa: BLE001 - every answer is one that the page can show
            return _problem(error)

    return endpoint


def _told(
    workspace: Workspace, do: Callable[[Workspace, dict[str, Any]], dict[str, Any] | None]
) -> Callable[[Request], Any]:
    async def endpoint(request: Request) -> Response:
        body = b""
        async for part in request.stream():
            body += part
            if len(body) > MOST_MESSAGE:
                return _problem(RecordingError("the message is too long", remedy="reload the page"))
        try:
            told = json.loads(body or b"{}")
            if not isinstance(told, dict):
                raise TypeError("not an object")
            return JSONResponse(await anyio.to_thread.run_sync(do, workspace, told) or {})
        except (KeyError, TypeError, ValueError) as error:
            if isinstance(error, ExoidError):
                return _problem(error)
            return _problem(RecordingError(f"the message cannot be understood ({error})", remedy="reload the page"))
        except Exception as error:  # noqa: BLE001 - every answer is one that the page can show
            return _problem(error)

    return endpoint


def _served(workspace: Workspace, do: Callable[[Workspace, Request], Any]) -> Callable[[Request], Any]:
    async def endpoint(request: Request) -> Response:
        return await do(workspace, request)

    return endpoint


def _problem(error: Exception) -> Response:
    # A refusal is an answer like another: as a status of HTTP it would be an error in the browser's console.
    if isinstance(error, ExoidError):
        return JSONResponse({"refused": error_json(error)})
    if isinstance(error, OSError):
        return JSONResponse({"refused": {"what": printable(str(error.strerror or error)), "where": "", "remedy": ""}})
    traceback.print_exception(error)
    said = {"what": f"internal error in exoid ({type(error).__name__})", "where": "",
            "remedy": "please report what the terminal says"}  # fmt: skip
    return JSONResponse(said, status_code=500)


def _session(workspace: Workspace) -> Any:
    if workspace.session is None:
        raise RecordingError("nothing is open yet", remedy="give at least one recording to fit")
    return workspace.session


def _number(request: Request, name: str) -> int:
    text = request.query_params.get(name, "")
    if not text.isdecimal() or len(text) > 9:
        raise RecordingError(f"{name} is no number", remedy="reload the page")
    return int(text)


def _bytes(content: bytes) -> Response:
    return Response(content, media_type="application/octet-stream")


def _download(text: str, name: str, kind: str) -> Response:
    return PlainTextResponse(text, media_type=kind, headers={"content-disposition": f'attachment; filename="{name}"'})
