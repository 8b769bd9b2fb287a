"""A folder with recordings and other files: read and said alike on the command line, in Python and on the page."""

from __future__ import annotations

import shutil
import zipfile

import numpy as np
import pytest

from exoid.apps.page import views
from exoid.apps.page.given import read_given
from exoid.apps.page.workspace import Workspace
from exoid.ground.errors import RecordingError
from exoid.measurement.reading.among import read_among
from exoid.measurement.reading.mapping import StatedMapping
from exoid.measurement.reading.read import read_as_told, read_recordings
from exoid.workbench.command import main
from exoid.workbench.commands.demo import DATA

LINE = "4 of 6 files left out: 1 of other types, 1 without motion, 2 without numbers"


@pytest.fixture
def folder(tmp_path):
    """Two trials, a static calibration, two texts of a camera and a document."""
    here = tmp_path / "session"
    here.mkdir()
    for name in ("train_1.csv", "verify.csv"):
        shutil.copy(DATA / name, here / name)
    rows = [f"{0.01 * k:.2f},0.1,-0.3,{1 + 0.01 * np.sin(k):.4f},0.4" for k in range(400)]
    (here / "static.csv").write_text("\n".join(["t,q1,q2,tau1,tau2", *rows, ""]), encoding="utf-8")
    for k in range(2):
        (here / f"camera_{k}.txt").write_text("codec: h264\nby: nobody\n", encoding="utf-8")
    (here / "notes.pdf").write_bytes(b"%PDF-1.4 nothing")
    return here


@pytest.mark.slow
def test_recordings_are_read_and_the_rest_is_named_in_one_line(folder, capsys):
    assert main(["compare", str(folder)]) == 0
    said = [line for line in capsys.readouterr().err.splitlines() if "left out" in line]
    assert len(said) == 1 and LINE in said[0] and "static.csv" in said[0]
    found = read_recordings(folder)
    assert [one.name for one in found] == ["train_1", "verify"] and LINE in found[0].findings[-1].what


def test_an_archive_and_a_pattern_are_read_as_a_folder_is(folder):
    archive = folder.parent / "session.zip"
    with zipfile.ZipFile(archive, "w") as content:
        for path in folder.iterdir():
            content.write(path, path.name)
    for given in (archive, f"{folder}/*"):
        found = read_recordings(given)
        assert [one.name for one in found] == ["train_1", "verify"] and LINE in found[0].findings[-1].what


def test_the_page_says_the_same_and_asks_nothing(folder, tmp_path):
    space = Workspace(tmp_path / "maps", 0)
    try:
        from exoid.measurement.reading.among import files_among

        files = files_among([folder])
        for path in files.paths:
            space.add_file(folder / path, path.rpartition("/")[2], among=True)
        for path, kind in files.others.items():
            space.leave_out(kind, path.rpartition("/")[2])
        for one in list(space.given):
            assert all(file["error"] is None for file in views.state(space)["files"])
            space.given[space.given.index(one)] = read_given(one, space.remembered)
            space.leave_others_out()
        state = views.state(space)
        assert LINE in state["left_out"] and [one["name"] for one in state["files"]] == ["train_1.csv", "verify.csv"]
    finally:
        space.close()


def test_what_is_named_is_never_left_out_nor_everything(folder, capsys):
    assert main(["compare", str(folder / "train_1.csv"), str(folder / "static.csv")]) == 2
    assert "no motion" in capsys.readouterr().err
    for name in ("train_1.csv", "verify.csv"):
        (folder / name).unlink()
    assert main(["compare", str(folder)]) == 2
    (folder / "emg.csv").write_text("\n".join(["t,emg", *(f"{k},{k % 7}" for k in range(90))]), encoding="utf-8")
    with pytest.raises(RecordingError, match="--map q1="):
        read_among([folder], lambda path: read_as_told(path, StatedMapping()))
