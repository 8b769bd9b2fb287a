"""What a person sees while waiting, and in a plain pipe."""

from __future__ import annotations

import json
import re
import sys
import time

import numpy as np
import pytest

from exoid.ground.output import OutputError, check_folder, json_text, make_folder, write_text
from exoid.ground.plain import plain
from exoid.workbench.terminal import progress as waiting
from exoid.workbench.terminal.screen import Screen, bar
from tests.waiting import HUNG


def test_no_terminal_no_bar(capsys):
    with waiting.progress("working") as report:
        report(0.5, "half way")
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(("quiet", "shown"), [(False, True), (True, False)])
def test_a_bar_appears_when_work_lasts(quiet, shown, monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(waiting, "PATIENCE", 0.01)
    monkeypatch.setenv("TERM", "xterm")
    seen, until = "", time.monotonic() + (HUNG if shown else 0.5)
    with waiting.progress("working", quiet=quiet) as report:
        while "half way" not in seen and time.monotonic() < until:  # drawn from another thread, when it has its turn
            report(0.5, "half way")
            time.sleep(0.05)
            seen += capsys.readouterr().err
    assert ("half way" in seen) is shown


def test_short_work_shows_nothing(monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    with waiting.progress("working") as report:
        report(1.0, "done")
    assert capsys.readouterr().err == ""


def test_part_of_a_progress():
    seen = []
    half = waiting.part(lambda f, text: seen.append((f, text)), 0.5, 1.0)
    half(0.5, "ranking")
    half(7.0, "end")
    assert seen == [(0.75, "ranking"), (1.0, "end")]


def test_tables_in_a_pipe_fold_and_cut_nothing_off(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    long = "a sentence that is longer than any terminal " * 6
    Screen().table("Title", ("name", "value", "text"), [("a", "1.5", long), ("b", "-", "short")])
    out = capsys.readouterr().out
    assert len(re.findall("terminal", out)) == 6
    assert max(len(line) for line in out.splitlines()) <= 60
    assert "\x1b" not in out
    assert all(line == line.rstrip() for line in out.splitlines())


def test_text_is_not_markup(capsys):
    Screen().table("", ("[bold]head",), [("[red]x[/red]",)])
    assert "[red]x[/red]" in capsys.readouterr().out


def test_a_silent_screen(capsys):
    Screen(silent=True).say("x")
    Screen(silent=True).table("", ("a",), [("b",)])
    assert capsys.readouterr().out == ""


def test_bars_fill_in_eighths():
    assert (bar(0.0), bar(1.0, 4), bar(0.5, 4), bar(9.0, 2)) == ("", "████", "██", "██")
    assert bar(1 / 16, 2) == "▏"


def test_json_is_strict():
    payload = {
        "a": np.array([1.0, np.nan]),
        "b": float("inf"),
        "c": np.float64(2.0),
        "d": (np.int64(3), np.bool_(True)),
    }
    text = json_text(payload)
    assert json.loads(text, parse_constant=pytest.fail) == {"a": [1.0, None], "b": None, "c": 2.0, "d": [3, True]}
    with pytest.raises(TypeError, match="no JSON form"):
        plain(object())


def test_files_are_written_whole_or_refused(tmp_path):
    assert write_text(tmp_path / "x.txt", "θ").read_text("utf-8") == "θ"
    (tmp_path / "file").write_text("")
    for use in (check_folder, make_folder):
        with pytest.raises(OutputError, match="cannot be written"):
            use(tmp_path / "file" / "below")
    check_folder(tmp_path / "new" / "deep")
    assert not (tmp_path / "new").exists()
