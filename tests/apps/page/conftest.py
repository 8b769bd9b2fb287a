"""A server of `exoid open` and a browser to look at it; nothing here waits for a time, only for what is to be seen."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.waiting import HUNG

ROOT = Path(__file__).parents[3]
PATIENCE = 1000.0 * HUNG
"""Milliseconds until a page counts as stuck."""


@pytest.fixture(scope="session")
def chromium():
    playwright = pytest.importorskip("playwright.sync_api")
    path = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if path is None:
        pytest.skip("there is no chromium on this machine (apt-get install chromium)")
    playwright.expect.set_options(timeout=PATIENCE)
    with playwright.sync_playwright() as start:
        browser = start.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield browser
        browser.close()


@dataclass
class Server:
    """A running `exoid open`: its process, and the address that it printed."""

    process: subprocess.Popen
    url: str
    folder: Path

    def end(self, how=signal.SIGINT):
        if self.process.poll() is None:
            self.process.send_signal(how)
        return self.process.wait(timeout=HUNG)


@pytest.fixture
def serve(tmp_path):
    """Return what starts `exoid open --no-browser` with further words; it is ended after the test."""
    started = []

    def start(*words, package=ROOT):
        process = subprocess.Popen(
            [sys.executable, "-m", "exoid", "open", "--no-browser", "--quiet", *map(str, words)],
            cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(package)}, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        server = Server(process, process.stdout.readline().strip(), tmp_path)
        started.append(server)
        return server

    yield start
    for server in started:
        server.end()
        server.process.stdout.close()


@dataclass
class Seen:
    """What a browser complained of, and where it went."""

    errors: list
    elsewhere: list


@pytest.fixture
def visit(chromium):
    """Return what opens an address in a tab of a new window; nothing may be complained of or fetched elsewhere."""
    contexts, seen = [], Seen([], [])

    def go(url, width=1280, context=None):
        if context is None:
            context = chromium.new_context(viewport={"width": width, "height": 900}, accept_downloads=True)
            context.grant_permissions(["clipboard-read", "clipboard-write"])
            context.set_default_timeout(PATIENCE)
            contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: seen.errors.append(str(error)))
        page.on("console", lambda message: seen.errors.append(message.text) if message.type == "error" else None)
        page.on("request", lambda request: _note(seen, request.url, url))
        page.goto(url)
        return page

    yield go
    for context in contexts:
        context.close()  # nothing happens where the test closed it
    assert seen.errors == [] and seen.elsewhere == []


def _note(seen, address, url):
    if not address.startswith((url.partition("?")[0], "data:", "blob:")):
        seen.elsewhere.append(address)
