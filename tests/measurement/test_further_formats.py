"""Formats of other worlds: OpenSim, spreadsheets, TDMS, ROS bags, objects of MATLAB, archives, tables in memory."""

import datetime
import zipfile

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tables import leg, text
from written import FORMATS, bag

from exoid.ground.errors import RecordingError
from exoid.measurement.reading.read import read_recording, read_recordings

LEG = leg(800)
Q = np.column_stack([LEG["q1"], LEG["q2"]])
TAU = np.column_stack([LEG["tau1"], LEG["tau2"]])
NAMES = ("hip", "knee")


@pytest.mark.parametrize("name", FORMATS)
def test_reads_alike_and_breaks_politely(name, tmp_path):
    path = tmp_path / name
    FORMATS[name](path, LEG)
    recording = read_recording(path)
    np.testing.assert_allclose(recording.q, Q, atol=1e-8)
    np.testing.assert_allclose(recording.tau, TAU, rtol=1e-7, atol=1e-7)
    np.testing.assert_allclose(recording.t - recording.t[0], LEG["t"], atol=1e-6)
    target = next(file for file in path.iterdir() if file.suffix != ".yaml") if path.is_dir() else path
    whole = target.read_bytes()
    for keep in (0.7, 0.3):
        target.write_bytes(whole[: int(keep * len(whole))])
        try:
            shorter = read_recording(path)
        except RecordingError as error:
            assert error.remedy
        else:
            assert len(shorter) < 800


@pytest.mark.slow
@pytest.mark.parametrize("name", ["a.xlsx", "a.tdms", "a.bag", "a.mcap", "a.db3", "a.mot", "v7.mat", "a.zip"])
@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(noise=st.binary(max_size=300))
def test_any_bytes_are_refused(name, tmp_path, noise):
    heads = {"a.xlsx": b"PK\x03\x04", "a.tdms": b"TDSm", "a.bag": b"#ROSBAG V2.0\n", "a.mcap": b"\x89MCAP0\r\n",
             "a.db3": b"SQLite format 3\x00", "a.mot": b"endheader\n", "v7.mat": b"MATLAB 5.0 MAT-file".ljust(116) +
             b"\x01\0\0\0\0\0\0\0\0\x01IM", "a.zip": b"PK\x03\x04"}  # fmt: skip
    path = tmp_path / name
    path.write_bytes(heads[name] + noise)
    with pytest.raises(RecordingError):
        read_recording(path)


def test_topics_of_a_bag_come_onto_one_clock(tmp_path):
    bag(tmp_path / "bag", LEG, two_topics=True)
    recording = read_recording(tmp_path / "bag")
    np.testing.assert_allclose(recording.tau[5:-5], TAU[5:-5], rtol=1e-6, atol=1e-6)
    assert any("put on the clock of /joint_states" in f.what for f in recording.findings)


def test_folders_patterns_and_archives(tmp_path, monkeypatch):
    folder = tmp_path / "runs"
    folder.mkdir()
    for k in (1, 2):
        (folder / f"run_{k}.csv").write_text(text(LEG))
    (folder / "notes.md").write_text("x")
    (folder / "exoid.toml").write_text("")
    with zipfile.ZipFile(tmp_path / "runs.zip", "w") as archive:
        for k in (1, 2):
            archive.write(folder / f"run_{k}.csv", f"day/run_{k}.csv")
        archive.writestr("../evil.csv", "x")
        archive.writestr("__MACOSX/run.csv", "x")
    names = ["run_1", "run_2"]
    assert [one.name for one in read_recordings([folder])] == names
    assert [one.name for one in read_recordings([f"{folder}/*.csv"])] == names
    member = f"{tmp_path}/runs.zip/day/run_2.csv"
    one = read_recording(member)
    assert one.name == "run_2" and one.source.path == member
    assert one.source.sha256 == read_recording(folder / "run_2.csv").source.sha256
    with pytest.raises(RecordingError, match="holds 3 recordings"):
        read_recording(tmp_path / "runs.zip")
    with pytest.raises(RecordingError, match="no file matches"):
        read_recordings([f"{folder}/*.parquet"])
    with pytest.raises(RecordingError, match=r"2 files do not exist: x\.csv, y\.csv"):
        read_recordings(["x.csv", "y.csv"])
    assert not (tmp_path.parent / "evil.csv").exists()


FRAMES = {
    "pandas": lambda: pd.DataFrame(LEG),
    "pandas, time as index": lambda: pd.DataFrame(LEG).set_index("t"),
    "pandas, dates as index": lambda: pd.DataFrame(
        {k: v for k, v in LEG.items() if k != "t"},
        index=pd.DatetimeIndex(datetime.datetime(2024, 5, 1) + pd.to_timedelta(LEG["t"], unit="s")),
    ),
    "pandas, two levels": lambda: pd.DataFrame(
        {("time", ""): LEG["t"], ("q", "hip"): LEG["q1"], ("q", "knee"): LEG["q2"], ("tau", "hip"): LEG["tau1"],
         ("tau", "knee"): LEG["tau2"]}),
    "mapping": lambda: {"t": LEG["t"], "q": Q, "tau": TAU},
    "structured": lambda: np.rec.fromarrays(list(LEG.values()), names=list(LEG)),
    "polars": lambda: pytest.importorskip("polars").DataFrame(LEG),
    "polars, lazy": lambda: pytest.importorskip("polars").LazyFrame(LEG),
    "pyarrow": lambda: pytest.importorskip("pyarrow").table(LEG),
    "xarray": lambda: pytest.importorskip("xarray").Dataset(
        {"q": (("time", "joint"), Q), "tau": (("time", "joint"), TAU)},
        coords={"time": LEG["t"], "joint": list(NAMES)}),
}  # fmt: skip


@pytest.mark.parametrize("kind", FRAMES)
def test_tables_in_memory(kind):
    recording = read_recording(FRAMES[kind]())
    np.testing.assert_allclose(recording.q, Q)
    np.testing.assert_allclose(recording.tau, TAU)
    np.testing.assert_allclose(recording.t - recording.t[0], LEG["t"], atol=1e-6)


def test_units_travel_with_a_table_and_back():
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("polars")
    data = xarray.Dataset({"q": (("time", "joint"), np.degrees(Q), {"units": "deg"}),
                           "tau": (("time", "joint"), TAU)}, coords={"time": LEG["t"]})  # fmt: skip
    recording = read_recording(data, name="trial")
    np.testing.assert_allclose(recording.q, Q)
    assert recording.name == "trial"
    for back in (recording.to_frame(), recording.to_polars(), recording.to_xarray()):
        np.testing.assert_allclose(read_recording(back).q, recording.q)


@pytest.mark.parametrize("thing", [3, "", None, [], pd.DataFrame(), {}, np.zeros((5, 5)), object()])
def test_what_is_no_table_is_refused(thing):
    with pytest.raises(RecordingError):
        read_recording(thing)
