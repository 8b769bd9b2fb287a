"""Starts the local server: a free port of this machine, a new token, and the address on the first line."""

from __future__ import annotations

import asyncio
import contextlib
import contextvars
import html
import os
import secrets
import signal
import socket
import sys
import threading
import time
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING

import uvicorn

from exoid.apps.page.app import application
from exoid.apps.page.work import start_work
from exoid.ground.errors import ExoidError, refused

if TYPE_CHECKING:
    from exoid.apps.page.workspace import Workspace

HOST = "127.0.0.1"
BROWSER = "browser"
REDIRECT = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>exoid</title>
<meta name="referrer" content="no-referrer"><meta http-equiv="refresh" content="0; url={address}"></head>
<body><a href="{address}">to the workbench</a></body></html>
"""
PATIENCE = 10.0
"""Seconds that the end of the page waits for what still works."""


def serve(workspace: Workspace, port: int, browser: bool, say: bool) -> None:
    """Serve until interrupted; ExoidError where the port is taken. `port` 0 takes a free one."""
    listening = _listen(port)
    number = listening.getsockname()[1]
    token = secrets.token_urlsafe(24)
    address = f"http://{HOST}:{number}/?token={token}"
    config = uvicorn.Config(
        application(workspace, token, number), log_level="error", access_log=False, lifespan="off",
        timeout_graceful_shutdown=1, server_header=False,
    )  # fmt: skip
    print(address, flush=True)
    if say:
        sys.stderr.write("exoid: the page is open at the address above; Ctrl-C ends it\n")
    start_work(workspace)
    if browser:
        threading.Thread(target=_show, args=(address, workspace.place), name=BROWSER, daemon=True).start()
    server = _Server(config, workspace)
    try:
        _obey_hangup(server)
        # In a context of its own: what is written while the page is open is there at once, not when the command ends.
        contextvars.Context().run(asyncio.run, server.serve(sockets=[listening]))
    finally:
        listening.close()
        workspace.close()
    finish_threads()


def _show(address: str, place: Path) -> None:
    """Open a browser, which may stay in the foreground of this terminal as long as it likes.

    It gets a file that leads to the address: everybody on this machine sees with which words a process was started, and
    the token is not for them. The `place` is this user's alone.
    """
    page = place / "open.html"
    with open(os.open(page, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as stream:
        stream.write(REDIRECT.format(address=html.escape(address)))
    opened = False
    with contextlib.suppress(webbrowser.Error, OSError):
        opened = webbrowser.open(page.as_uri())
    if not opened:
        sys.stderr.write("exoid: no browser could be opened; open the address above\n")


def _obey_hangup(server: _Server) -> None:
    """End when the terminal is closed, unless somebody wants it to stay (nohup)."""
    hangup = getattr(signal, "SIGHUP", None)
    with contextlib.suppress(ValueError):  # not the main thread: whoever runs it decides about signals
        if hangup is not None and signal.getsignal(hangup) != signal.SIG_IGN:
            signal.signal(hangup, server.handle_exit)


def finish_threads(patience: float = PATIENCE) -> None:
    """Wait for what is still being computed or written, a report perhaps. What lasts longer, or what the user does not
    wait for, ends with the process here: the interpreter's own end aborts under a thread inside compiled code.
    """
    until = time.monotonic() + patience
    working = [thread for thread in threading.enumerate() if thread.daemon and thread.name != BROWSER]
    with contextlib.suppress(KeyboardInterrupt):
        for thread in working:
            thread.join(max(0.0, until - time.monotonic()))
    if any(thread.is_alive() for thread in working):
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(0)


class _Server(uvicorn.Server):
    """A server of which an interruption is the ordinary end."""

    def __init__(self, config: uvicorn.Config, workspace: Workspace) -> None:
        super().__init__(config)
        self.workspace = workspace

    def handle_exit(self, sig: int, frame: object) -> None:
        """Stop; the second time at once. Nothing is raised again when it has stopped."""
        self.force_exit = self.should_exit
        self.should_exit = True
        self.workspace.end()  # who waits for news has waited enough


def _listen(port: int) -> socket.socket:
    what = f"port {port} cannot be used ({{}})"
    with refused(ExoidError, what, "--port", "leave it out: a free one is found"):
        return socket.create_server((HOST, port), backlog=128)
