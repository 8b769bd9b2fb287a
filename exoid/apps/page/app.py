"""The local server: every address of the page; what panels ask and do is theirs (`panels/`)."""

from __future__ import annotations

import shutil
from collections.abc import AsyncIterator, Callable
from functools import partial
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import anyio.to_thread
from starlette.applications import Starlette
from starlette.responses import FileResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from exoid.apps.page import panels, views
from exoid.apps.page.given import FIT, shown_name
from exoid.apps.page.guard import Guard
from exoid.apps.page.message import LONGEST, RELOAD, obey, read_message
from exoid.apps.page.reply import number_in
from exoid.diagnosis.report.page import report_style
from exoid.ground.errors import ExoidError, RecordingError, error_json, internal
from exoid.ground.files import MODEL_FILES
from exoid.ground.folder import with_apps
from exoid.measurement.reading.limits import MOST_BYTES
from exoid.measurement.reading.mapping import FILE as MAPPING
from exoid.measurement.reading.sources import kind_of_file

if TYPE_CHECKING:
    from starlette.requests import Request

    from exoid.apps.page.reply import Action, Answer
    from exoid.apps.page.workspace import Workspace

STATIC = Path(__file__).parent / "static"
DRAWN = "export function draw("
"""How the script of a panel begins to draw it."""
BEAT = 10.0
"""Seconds after which an open connection says that it is still there."""


def application(workspace: Workspace, token: str, port: int) -> Guard:
    """Return the guarded application."""

    routes = [
        Route("/", lambda request: FileResponse(STATIC / "index.html")),
        Route("/report.css", lambda request: Response(report_style(), media_type="text/css")),
        Route("/api/events", partial(_events, workspace)),
        Route("/panels.js", _scripts),
        Route("/api/state", lambda request: JSONResponse(views.state(workspace))),
        *(Route(f"/api/{name}", partial(_answered, workspace, ask)) for name, ask in _answers().items()),
        Route("/api/file", partial(_upload, workspace), methods=["PUT"]),
        Route("/api/session", partial(_upload_session, workspace), methods=["PUT"]),
        *(Route(f"/api/{name}", _told(workspace, name, do), methods=["POST"]) for name, do in actions().items()),
        *(Route(f"/static/panels/{path.name}", _file(path)) for path in panel_scripts().values()),
        Mount("/static", StaticFiles(directory=STATIC)),
    ]
    handlers: dict[Any, Any] = {ExoidError: _refused, OSError: _refused, Exception: _broken}
    return Guard(Starlette(routes=routes, exception_handlers=handlers), token, port)


def _file(path: Path) -> Callable[[Request], Response]:
    return lambda request: FileResponse(path)


def actions() -> dict[str, Action]:
    """Actions of all panels, by name."""
    return {name: do for panel in panel_modules() for name, do in getattr(panel, "ACTIONS", {}).items()}


def panel_modules() -> list[ModuleType]:
    """The modules of all panels, of the page and of apps."""
    return [import_module(module) for module in with_apps(panels).values()]


def panel_scripts() -> dict[str, Path]:
    """Scripts of all panels by name: those of the page lie in `static/panels`, those of apps beside their module."""
    own = {path.stem: path for path in (STATIC / "panels").glob("*.js")}
    theirs = (Path(str(module.__file__)).with_suffix(".js") for module in panel_modules())
    return dict(sorted((own | {path.stem: path for path in theirs if path.exists()}).items()))


def _answers() -> dict[str, Answer]:
    """Return {address: what answers} of all panels."""
    own = (getattr(panel, "ANSWERS", {}) for panel in panel_modules())
    return {name: answer for each in own for name, answer in each.items()}


def _answered(workspace: Workspace, ask: Answer, request: Request) -> Response:
    found = ask(workspace, request)
    return found if isinstance(found, Response) else JSONResponse(found)


def _scripts(request: Request) -> Response:
    """Return a script that brings every panel that can be drawn, each under its name."""
    drawn = [name for name, path in panel_scripts().items() if DRAWN in path.read_text("utf-8")]
    lines = (f'export * as {name} from "/static/panels/{name}.js";' for name in drawn)
    return Response("\n".join(lines), media_type="text/javascript")


# -- what is sent and heard ----------------------------------------------------------------------------------------


async def _upload(workspace: Workspace, request: Request) -> Response:
    """Take in a file that was dropped: a recording, a model, or what `exoid map` keeps. Of a folder only these."""
    name, role = request.query_params.get("name", ""), request.query_params.get("role", FIT)
    target = workspace.drop_place(name)
    await _written(request, target)

    def take() -> dict[str, Any]:
        if target.name == MAPPING:
            workspace.use_mapping(target)
        elif target.suffix.lower() in MODEL_FILES:
            workspace.use_model(target, name)
        elif "folder" in request.query_params and (kind := kind_of_file(target)):
            target.unlink()
            workspace.leave_out(kind, shown_name(name))
        else:
            return {"id": workspace.add_file(target, name, role, among="folder" in request.query_params).id}
        return {}

    return JSONResponse(await anyio.to_thread.run_sync(take))


async def _upload_session(workspace: Workspace, request: Request) -> Response:
    """Take in one file of the folder of a session that was dropped; `reopen` opens it when all are here."""
    drop = number_in(request, "drop")
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


def _told(workspace: Workspace, action: str, do: Action) -> Callable[[Request], Any]:
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
