"""A running server: who sees its token, what it makes of absurd messages, and what is left when it ends."""

from __future__ import annotations

import json
import os
import signal
import stat
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

import pytest

from exoid.apps.page.app import actions
from exoid.apps.page.message import STEPS, obey, read_message
from exoid.apps.page.workspace import Workspace
from exoid.ground.errors import RecordingError
from exoid.workbench.commands.demo import DATA
from tests.waiting import HUNG, until

ROOT = Path(__file__).parents[3]
NESTED = "[" * 100_000 + "]" * 100_000
KEYS = (
    "file", "at", "effect", "recording", "folder", "columns", "units", "spans", "box", "joint", "role", "drop", "seen",
)  # fmt: skip
VALUES = (
    None, True, [], {}, [[]], {"a": 1}, "", "x" * 100_000, "\0", "~nobody-of-that-name/x", 1e308, -1, 10**300, [1, 2],
    [["a", "b", "c"]], [[10**400, 0, 0]],
)  # fmt: skip
ABSURD = [
    NESTED, '{"a":' * 100_000 + "1" + "}" * 100_000, json.dumps({"a": json.loads("[" * 40 + "]" * 40)}),
    "{", "[]", "7", "null", '"x"', "\xff\xfe", '{"file": Infinity}', '{"file": NaN}', '{"file": 1e999}',
    '{"file": -1e999, "at": 1e999}', '{"at": ' + "9" * 4000 + "}", '{"at": ' + "9" * 6000 + "}", "{}",
    *(json.dumps(dict.fromkeys(KEYS, value)) for value in VALUES),
]  # fmt: skip
QUERIES = (
    "", "?recording=999999999&file=999999999&effect=%00&format=%ff", "?recording=-1", "?recording=%E2%82%AC",
)  # fmt: skip


def asked(server, path, body=None, method=None):
    """Return the status and the JSON of an answer."""
    address, _, token = server.url.partition("/?token=")
    data = None if body is None else body.encode("latin-1") if isinstance(body, str) else body
    request = urllib.request.Request(f"{address}{path}", data, {"X-Exoid-Token": token}, method=method)
    try:
        with urllib.request.urlopen(request, timeout=HUNG) as answer:
            return answer.status, json.loads(answer.read())
    except urllib.error.HTTPError as error:
        with error:
            return error.code, json.loads(error.read() or b"{}")


@pytest.mark.slow
def test_absurd_messages_are_refused_in_words(serve):
    server = serve()
    for action in sorted(set(actions()) - {"demo", "discover"}):
        for body in ABSURD:
            status, told = asked(server, f"/api/{action}", body)
            assert status == 200, (action, body[:80], told)
            assert "refused" not in told or told["refused"]["what"], (action, body[:80])
    for path in ("details", "motion", "error", "preview", "columns", "export", "report"):
        for query in QUERIES:
            assert asked(server, f"/api/{path}{query}")[0] == 200, path
    assert asked(server, "/api/state")[0] == 200


@pytest.mark.slow
def test_a_message_that_never_ends_is_cut_off(serve):
    server = serve()
    assert "too long" in asked(server, "/api/add", b" " * 1_500_000)[1]["refused"]["what"]


@pytest.mark.parametrize("text", [NESTED, '{"a": Infinity}', '{"a": 1e999}', "[]", "{"])
def test_a_message_is_an_object_of_finite_numbers(text):
    with pytest.raises(RecordingError):
        read_message(text.encode())


def test_steps_that_another_page_made_are_seen_before_they_are_built_upon(tmp_path):
    workspace = Workspace(tmp_path)

    def say(action, **told):
        return obey(workspace, action, actions()[action], told)

    workspace.history = workspace.history.add("stribeck:hip", "stribeck:knee")
    say("undo", page="one", seen=0)
    say("undo", page="one", seen=0)  # its own steps a page may make faster than it sees them
    assert workspace.history.at == 0
    with pytest.raises(RecordingError, match="changed elsewhere"):
        say("redo", page="two", seen=0)
    assert workspace.history.at == 0
    say("redo", page="two", seen=2)
    say("redo")  # who does not say what it has seen is believed
    assert workspace.history.at == 2 and len(workspace.edits) == 4
    for action in STEPS:
        with pytest.raises(RecordingError, match="changed elsewhere"):
            say(action, page="one", seen=2, at=0, effect="stribeck:hip")
    workspace.close()


WATCHED = """#!/usr/bin/env python3
import sys, time
with open(sys.argv[0] + ".seen", "w") as stream:
    stream.write("\\n".join(sys.argv[1:]))
time.sleep(600)
"""


@pytest.fixture
def started(tmp_path, monkeypatch):
    """A server whose browser stays in the foreground, as w3m does, and whose temporary folder is known."""
    pytest.importorskip("uvicorn")
    browser = tmp_path / "browser"
    browser.write_text(WATCHED.replace("/usr/bin/env python3", sys.executable))
    browser.chmod(0o755)
    (tmp_path / "tmp").mkdir()
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "BROWSER": str(browser), "TMPDIR": str(tmp_path / "tmp")}
    process = subprocess.Popen(
        [sys.executable, "-m", "exoid", "open"], cwd=tmp_path, env=environment, stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL, text=True, start_new_session=True,
    )  # fmt: skip
    process.url = process.stdout.readline().strip()
    yield process
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    process.stdout.close()


@pytest.mark.skipif(os.name != "posix", reason="access rights of POSIX")
def test_the_token_is_in_no_list_of_processes_and_a_browser_in_the_terminal_keeps_nothing_from_being_served(
    started, tmp_path
):
    assert asked(started, "/api/state")[0] == 200  # while the browser stays
    seen = tmp_path / "browser.seen"
    until(lambda: seen.exists() and seen.read_text())
    token = started.url.partition("token=")[2]
    address = seen.read_text()
    assert address.startswith("file:///") and token not in address
    page = Path(address.removeprefix("file://"))
    assert started.url in page.read_text()
    assert stat.S_IMODE(page.stat().st_mode) == 0o600 and stat.S_IMODE(page.parent.stat().st_mode) == 0o700


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="no terminal to be closed")
@pytest.mark.parametrize("number", ["SIGHUP", "SIGTERM", "SIGINT"])
def test_what_was_dropped_is_cleared_away_however_it_ends(number, started, tmp_path):
    content = (DATA / "train_1.csv").read_bytes()
    assert asked(started, "/api/file?name=run.csv", content, "PUT")[0] == 200
    assert any(path.name == "run.csv" for path in (tmp_path / "tmp").rglob("*"))
    started.send_signal(getattr(signal, number))
    assert started.wait(timeout=HUNG) == 0
    assert not [path for path in (tmp_path / "tmp").rglob("*") if path.is_file()]


@pytest.mark.skipif(os.name != "posix", reason="locks of POSIX")
def test_what_a_killed_one_left_is_cleared_away_by_the_next(tmp_path, monkeypatch):
    pytest.importorskip("fcntl")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    left = tmp_path / "exoid-open-left"
    (left / "1").mkdir(parents=True)
    (left / ".lock").write_text("")
    other = tmp_path / "exoid-open-link"
    other.symlink_to(tmp_path.parent)
    (tmp_path / "exoid-open-new").mkdir()
    first, second = Workspace(tmp_path), Workspace(tmp_path)
    assert not left.exists() and other.is_symlink() and (tmp_path / "exoid-open-new").is_dir()
    assert first.place.is_dir() and second.place.is_dir()
    for workspace in (first, second):
        workspace.close()
        assert not workspace.place.exists()


def test_nothing_is_left_of_what_could_not_be_opened(tmp_path, monkeypatch):
    from exoid.workbench.command import main

    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "tmp"))
    (tmp_path / "tmp").mkdir()
    assert main(["open", "--model", str(tmp_path / "missing.toml"), "--no-browser"]) == 2
    assert not list((tmp_path / "tmp").iterdir())
