"""Each recording that cannot be used, with the message it must give: what, where, what to do."""

import os

import numpy as np
import pytest

from exoid.ground.errors import RecordingError
from exoid.measurement.reading.read import read_recording, read_recordings
from exoid.measurement.recording import Recording, write_recording
from exoid.workbench.command import main

HEADER = "t,q1,q2,tau1,tau2"
T = np.arange(800) * 0.01
COLUMNS = {
    "t": T,
    "q1": 0.6 + 0.5 * np.sin(2 * T),
    "q2": -0.9 + 0.5 * np.sin(3 * T),
    "tau1": 30 * np.sin(0.6 + 0.5 * np.sin(2 * T)),
    "tau2": 5 * np.cos(3 * T),
}


def table(header=HEADER, sep=",", decimal=".", **changes):
    columns = {**COLUMNS, **changes}
    cells = [
        [x if isinstance(x, str) else f"{x:.7g}".replace(".", decimal) for x in column] for column in columns.values()
    ]
    return "\n".join([header, *(sep.join(row) for row in zip(*cells, strict=True))]) + "\n"


NONE = np.zeros_like(T)
CASES = {
    "empty": ("", {}, "the file is empty", "copy was complete"),
    "blank": (" \n\n", {}, "nothing but blanks", "record again"),
    "header only": (HEADER + "\n", {}, "no rows of numbers", "one row of numbers per sample"),
    "prose": ("hello, world\nthis is no table\n", {}, "no rows of numbers", "one header line"),
    "too short": (table()[:900], {}, "too short to identify anything (at least 50)", "at least 10 s"),
    "too brief": (table(t=T / 20), {}, "lasts 0.4 s: too short", "at least 10 s"),
    "missing column": (table("t,q1,qq2,tau1,tau2"), {}, "q2 was found (columns found: t, q1, qq2,", "--map q2=qq2?"),
    "no names": (table("")[1:], {}, "no column for t, q1, q2", "--map t=COLUMN"),
    "twice the same name": (table("t,q1,q1,tau1,tau2"), {}, "more than one column can be q1", "--map q1=q1#1"),
    "two candidates": (
        table("t,q1,theta1,tau1,tau2"),
        {},
        "more than one column can be q1: 'q1', 'theta1'",
        "--map q1=",
    ),
    "mapped twice": (table(), {"columns": {"q1": "q1", "q2": "q1"}}, "mapped to both q1 and q2", "once"),
    "map to nowhere": (table(), {"columns": {"q1": "q3"}}, "column 'q3' (q1) is not in the file", "did you mean 'q"),
    "map key": (table(), {"columns": {"qq1": "q1"}}, "--map names 'qq1'", "did you mean 'q1'?"),
    "units key": (table(), {"units": {"taw": "Nm"}}, "--units names 'taw'", "did you mean 'tau'?"),
    "unknown unit": (
        table(),
        {"units": {"q": "degs"}},
        "unit 'degs' of column 'q1'",
        "--units q1=deg,q2=deg if it is so; known: rad,",
    ),
    "unknown header unit": (table("t,q1 [furlong],q2,tau1,tau2"), {}, "unit 'furlong'", "--units q1=rad if it is so"),
    "not numeric": (
        table(q1=["abc"] * 800),
        {},
        "not usable numbers (800 text, for example 'abc' in row 2)",
        "--map q1=COLUMN",
    ),
    "mostly empty": (
        table(tau2=np.where(T > 0.5, np.nan, T)),
        {},
        "cells of tau2 are not usable numbers",
        "right column",
    ),
    "all infinite": (table(tau1=NONE + np.inf), {}, "infinite", "right column"),
    "no motion": (table(q1=NONE, q2=NONE), {}, "no motion: the angles move by 0 rad, 0 rad", "every joint"),
    "no torque": (table(tau1=NONE, tau2=NONE), {}, "no torque changes (0 N·m, 0 N·m)", "--map tau1=COLUMN"),
    "time stands still": (table(t=NONE), {}, "the time is the same in every row", "--map t=COLUMN"),
    "two recordings": (table() + table().split("\n", 1)[1], {}, "the clock starts again", "one file per recording"),
    "row numbers for time": (table(t=T * 100), {}, "counts 0, 1, 2", "--rate 100"),
    "slow": (table(t=T * 20), {"units": {"t": "s"}}, "sampled at 5 Hz, too slow", "100 Hz or faster"),
    "row names without a header": (
        table("q1,q2,tau1,tau2"),
        {},
        "the header has 4 names, the rows have 5",
        "row numbers",
    ),
    "one endless line": (",".join(["1.5"] * 60000), {}, "one line has", "transpose"),
    "comma twice": (table(decimal=","), {}, "the header has 5 names, the rows have 10 cells", "semicolons"),
}


@pytest.mark.parametrize("name", CASES)
def test_refused_with_reason_place_and_remedy(name, tmp_path):
    content, options, what, remedy = CASES[name]
    path = tmp_path / "run.csv"
    path.write_text(content)
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    assert what in caught.value.what
    assert remedy in caught.value.remedy
    assert str(path) in caught.value.where
    assert path.read_text() == content


def test_what_is_not_a_file(tmp_path):
    (tmp_path / "run_1.csv").write_text(table())
    for path, what, remedy in (
        (tmp_path, "this is a folder", "take the whole folder"),
        (tmp_path / "run_l.csv", "there is no such file", "did you mean"),
        (tmp_path / "nowhere" / "a.csv", "there is no such file", "does not exist either"),
        (tmp_path / ("x" * 5000), "this is not a path", "spelling"),
    ):
        with pytest.raises(RecordingError) as caught:
            read_recording(path)
        assert what in caught.value.what and remedy in caught.value.remedy
    os.mkfifo(tmp_path / "pipe.csv")
    with pytest.raises(RecordingError, match="not an ordinary file"):
        read_recording(tmp_path / "pipe.csv")


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="the superuser may read everything")
def test_unreadable_file(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(table())
    path.chmod(0)
    with pytest.raises(RecordingError, match="cannot be read"):
        read_recording(path)


def test_wrong_suffixes_and_contents(tmp_path):
    noise = np.random.default_rng(0).bytes(4000)
    for name, content, what in (
        ("a.csv", noise, "binary data"),
        ("a.xlsx", b"PK\x03\x04" + noise, "spreadsheet"),
        ("a.docx2", b"hello", "files of type .docx2 are not read"),
        ("a.npz", noise, "damaged"),
        ("a.mat", noise, "damaged"),
        ("a.h5", noise, "damaged"),
        ("a.parquet", noise, "damaged"),
        ("b.csv", b"\x89HDF\r\n\x1a\n" + noise, "damaged"),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(RecordingError, match=what):
            read_recording(tmp_path / name)


def test_pickles_are_never_opened(tmp_path):
    class Trap:
        def __reduce__(self):
            return os.mkdir, (str(tmp_path / "sprung"),)

    np.savez(tmp_path / "a.npz", t=np.array([Trap()], dtype=object))
    with pytest.raises(RecordingError, match="can run code"):
        read_recording(tmp_path / "a.npz")
    assert not (tmp_path / "sprung").exists()


def test_nothing_is_left_when_writing_fails(tmp_path):
    (tmp_path / "file").write_text("x")
    pair = np.zeros((3, 2))
    recording = Recording("r", np.arange(3.0), pair, pair)
    with pytest.raises(RecordingError, match="cannot be written"):
        write_recording(recording, tmp_path / "file" / "a.csv")
    assert [entry.name for entry in tmp_path.iterdir()] == ["file"]


def test_a_recording_checks_itself():
    pair = np.zeros((3, 2))
    with pytest.raises(ValueError, match="increase strictly"):
        Recording("r", np.array([0.0, 1.0, 1.0]), pair, pair)
    with pytest.raises(ValueError, match="not finite"):
        Recording("r", np.arange(3.0), pair * np.nan, pair)
    for huge in (1e154, 1e308):  # NumPy would warn of its overflows, far from here
        with pytest.raises(ValueError, match=r"as large as 1e\+.*no sensor measures"):
            Recording("r", np.arange(3.0), pair, pair + huge)
    with pytest.raises(ValueError, match="shape"):
        Recording("r", np.arange(4.0), pair, pair)


def test_missing_files_of_both_groups_are_named_at_once(capsys):
    assert main(["compare", "nowhere_1.csv", "--verify", "nowhere_2.csv"]) == 2
    said = capsys.readouterr().err
    assert "nowhere_1.csv" in said and "nowhere_2.csv" in said


@pytest.mark.parametrize("arguments", [
    "compare a", "compare b c --verify a", "identify b --model a", "watch a b", "map a", "campaign a --out b",
    "reveal a", "export a --out c", "generate a",
])  # fmt: skip
def test_links_that_go_in_a_circle_are_refused_in_words(tmp_path, monkeypatch, capsys, arguments):
    monkeypatch.chdir(tmp_path)
    os.symlink("b", "a")
    os.symlink("a", "b")
    assert main(arguments.split()) == 2
    said = capsys.readouterr().err
    assert said and "Traceback" not in said


@pytest.mark.slow
@pytest.mark.parametrize("name", [b"run_\xff\xe4.csv", b"$\\foo{$.csv", b"a\nb.csv"])
def test_a_file_of_any_name_gets_its_figures(tmp_path, name):
    """No UTF-8, what matplotlib takes for mathematics, a line feed."""
    path = os.fsdecode(os.path.join(os.fsencode(tmp_path), name))
    try:
        with open(path, "w") as stream:
            stream.write(table())
    except OSError:
        pytest.skip("this file system has no such names")
    assert main(["compare", path, "--out", str(tmp_path / "out"), "--quiet"]) == 0
    assert "data:image" in (tmp_path / "out" / "report.html").read_text()


def test_a_single_path_is_no_sequence_of_letters(tmp_path):
    (tmp_path / "run.csv").write_text(table())
    (tmp_path / "angles.csv").write_text(table("t,a,b,c,d"))
    (one,) = read_recordings(str(tmp_path / "run.csv"))
    (other,) = read_recordings(tmp_path / "run.csv")
    assert one.name == other.name == "run"
    with pytest.raises(RecordingError, match=r"angles\.csv"):
        read_recording(tmp_path / "run.csv", join=str(tmp_path / "angles.csv"))
