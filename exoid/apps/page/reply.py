"""Requests of the page, and answers to them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from starlette.responses import JSONResponse, PlainTextResponse, Response

from exoid.apps.page.message import RELOAD
from exoid.ground.errors import RecordingError

if TYPE_CHECKING:
    from starlette.requests import Request

    from exoid.apps.page.workspace import Workspace

    Answer = Callable[[Workspace, Request], Response | dict[str, Any]]
    Action = Callable[[Workspace, dict[str, Any]], Any]


def number_in(request: Request, name: str) -> int:
    """Return the number that a request names; RecordingError where it names none."""
    text = request.query_params.get(name, "")
    if not text.isdecimal() or len(text) > 9:
        raise RecordingError(f"{name} is no number", remedy=RELOAD)
    return int(text)


def text_in(request: Request, name: str) -> str:
    """Return the text that a request names, "" where it names none."""
    return str(request.query_params.get(name, ""))


def as_json(content: Any) -> Response:
    """Return plain data as an answer."""
    return JSONResponse(content)


def as_bytes(content: bytes) -> Response:
    """Return numbers as an answer."""
    return Response(content, media_type="application/octet-stream")


def as_file(content: str | bytes, name: str, kind: str) -> Response:
    """Return a file to be kept."""
    headers = {"content-disposition": f'attachment; filename="{name}"'}
    made = PlainTextResponse if isinstance(content, str) else Response
    return made(content, media_type=kind, headers=headers)
