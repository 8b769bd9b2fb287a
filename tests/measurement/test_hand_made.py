"""Files as spreadsheets, ROS, Simulink and people write them: read right, or refused with a remedy that works."""

import datetime

import h5py
import numpy as np
import pandas as pd
import pytest
import scipy.io
from hypothesis import given
from hypothesis import strategies as st
from tables import leg

from exoid.ground.errors import RecordingError
from exoid.measurement.reading.made_times import join_split
from exoid.measurement.reading.raw import RawColumn, RawTable, ungrouped
from exoid.measurement.reading.read import read_recording
from exoid.measurement.reading.stamps import seconds

LEG = leg()
M = np.column_stack(list(LEG.values()))
HEAD = "t,q1,q2,tau1,tau2"
START = datetime.datetime(2024, 3, 1, 12, 0, 0)


def table(header=HEAD, sep=",", time=None, cell="{:.9g}", decimal="."):
    """Text of the leg; `time` writes a stamp given in s."""
    rows = []
    for row in M:
        cells = [cell.format(x).replace(".", decimal) for x in row]
        if time:
            cells[0] = time(row[0])
        rows.append(sep.join(cells))
    return "\n".join([header, *rows]) + "\n"


def dated(pattern, digits=6, later=0.0):
    def stamp(t):
        text = (START + datetime.timedelta(seconds=t + later)).strftime(pattern)
        return text[: len(text) - 6 + digits] if pattern.endswith("%f") else text

    return stamp


def comma(text):
    return text.replace(",", "_").replace(".", ",").replace("_", ".")


def ros(t):
    return f"{1_700_000_000 + int(t + 1e-9)},{round((t + 1e-9) % 1 * 1e9) // 1000 * 1000}"


MS = "t [ms];q1;q2;tau1;tau2"
TEXTS = {
    "us date": table(time=dated("%m/%d/%Y %H:%M:%S.%f")),
    "german date": table(time=dated("%d.%m.%Y %H:%M:%S.%f")),
    "half days": table(time=lambda t: dated("%m/%d/%Y %I:%M:%S.%f")(t) + " PM"),
    "past noon": table(time=lambda t: dated("%I:%M:%S.%f", later=-5.0)(t) + (" AM" if t < 4.9999 else " PM")),
    "clock": table(time=dated("%H:%M:%S.%f", 3)),
    "clock past midnight": table(time=dated("%H:%M:%S.%f", later=43195.0)),
    "date past midnight": table(time=dated("%d.%m.%Y %H:%M:%S.%f", later=43195.0)),
    "day count of a spreadsheet": table(time=lambda t: f"{45352.5 + t / 86400:.12f}"),
    "thousands and point": table(MS, ";", time=lambda t: f"{1e3 * t + 5000:,.3f}"),
    "thousands in quotes": table(MS.replace(";", ","), time=lambda t: f'"{1e3 * t + 5000:,.3f}"'),
    "thousands and comma": table(MS, ";", time=lambda t: comma(f"{1e3 * t + 5000:,.3f}"), decimal=","),
    "thousands apart": table(
        MS, ";", time=lambda t: f"{1e3 * t + 5000:,.3f}".replace(",", "\u202f").replace(".", ","), decimal=","
    ),
    "minus of typography": table().replace("-", "\u2212"),
    "joints from nought": table("t,q0,q1,tau0,tau1"),
    "arrays": table("time,position[0],position[1],effort[0],effort[1]"),
    "ros": table("header.stamp.secs,header.stamp.nsecs,position0,position1,effort0,effort1", time=ros),
    "ros 2": table("header.stamp.sec,header.stamp.nanosec,q1,q2,tau1,tau2", time=ros),
    "ros with arrival": table(
        "%time,field.header.stamp.secs,field.header.stamp.nsecs,field.position0,field.position1,field.effort0,field.effort1",
        time=lambda t: f"{round(1.7e18 + 1e9 * t + 1e6 * np.sin(t))},{ros(t)}",
    ),
    "plotjuggler": table("__time,/js/hip/position,/js/knee/position,/js/hip/effort,/js/knee/effort"),
    "the same column twice": "\n".join(f"{line},{line.split(',')[1]}" for line in table().splitlines()),
}


@pytest.mark.parametrize("name", TEXTS)
def test_text_is_read_right(name, tmp_path):
    path = tmp_path / "run.csv"
    path.write_text(TEXTS[name], encoding="utf-8")
    recording = read_recording(path)
    assert recording.valid.all() and len(recording) == len(M)
    np.testing.assert_allclose(recording.q, M[:, 1:3], atol=1e-8)
    np.testing.assert_allclose(recording.tau, M[:, 3:5], atol=1e-6)
    np.testing.assert_allclose(np.diff(recording.t), 0.01, atol=2e-6)
    assert not [one for one in recording.findings if one.severity == "warning"]


def test_minutes_and_tenths_are_spaced_and_said_so(tmp_path):
    """What a spreadsheet shows of a time unless told otherwise has one decimal."""
    (tmp_path / "a.csv").write_text(table(time=dated("%M:%S.%f", 1)))
    recording = read_recording(tmp_path / "a.csv")
    assert recording.rate == pytest.approx(100.0, rel=1e-3) and "too few digits" in str(recording.findings)


def test_three_decimals_behind_a_comma_are_no_thousands(tmp_path):
    (tmp_path / "a.csv").write_text(table(HEAD.replace(",", ";"), ";", cell="{:.3f}", decimal=","))
    np.testing.assert_allclose(read_recording(tmp_path / "a.csv").tau, M[:, 3:5], atol=6e-4)


def test_one_name_twice_can_be_mapped(tmp_path):
    (tmp_path / "a.csv").write_text(table("t,q1,q1,tau1,tau2"))
    with pytest.raises(RecordingError, match="'q1#1', 'q1#2'"):
        read_recording(tmp_path / "a.csv")
    with pytest.raises(RecordingError, match="stands 2 times"):
        read_recording(tmp_path / "a.csv", columns={"q1": "q1"})
    recording = read_recording(tmp_path / "a.csv", columns={"q1": "q1#1", "q2": "q1#2"})
    np.testing.assert_allclose(recording.q, M[:, 1:3], atol=1e-8)


def test_cells_of_errors_and_a_header_in_the_middle_are_masked(tmp_path):
    rows = table().splitlines()
    rows[7] = rows[7].replace(rows[7].split(",")[2], "#DIV/0!")
    rows.insert(700, HEAD)
    (tmp_path / "a.csv").write_text("\n".join(rows))
    recording = read_recording(tmp_path / "a.csv")
    assert np.flatnonzero(~recording.complete).tolist() == [6, 699]
    assert recording.row[[6, 699]].tolist() == [8, 701]


def _timeseries(path):
    scipy.io.savemat(path, {"logs": {name: {"Time": LEG["t"], "Data": LEG[name]} for name in HEAD.split(",")[1:]}})


def _to_workspace(path):
    kinds = [("label", object), ("values", object), ("dimensions", object)]
    signals = [(name, LEG[name][:, None], 1.0) for name in HEAD.split(",")[1:]]
    scipy.io.savemat(path, {"out": {"time": LEG["t"][:, None], "signals": np.array(signals, dtype=kinds)}})


def _groups(path):
    with h5py.File(path, "w") as file:
        for name in HEAD.split(",")[1:]:
            file[f"logs/{name}/Time"], file[f"logs/{name}/Data"] = LEG["t"][None], LEG[name][None]


def _time_index(path):
    pytest.importorskip("pyarrow")
    index = pd.to_datetime(1_700_000_000 * 10**9 + np.round(LEG["t"] * 1e9).astype(np.int64))
    pd.DataFrame({name: LEG[name] for name in HEAD.split(",")[1:]}, index=index).to_parquet(path)


@pytest.mark.parametrize(
    ("name", "write"),
    [("a.mat", _timeseries), ("b.mat", _to_workspace), ("a.h5", _groups), ("a.parquet", _time_index)],
)
def test_binary_is_read_right(name, write, tmp_path):
    write(tmp_path / name)
    recording = read_recording(tmp_path / name)
    np.testing.assert_allclose(recording.q, M[:, 1:3])
    np.testing.assert_allclose(recording.t, LEG["t"], atol=1e-6)


def test_series_with_clocks_of_their_own_are_refused(tmp_path):
    logs = {name: {"Time": LEG["t"] + 0.001 * k, "Data": LEG[name]} for k, name in enumerate(HEAD.split(",")[1:])}
    scipy.io.savemat(tmp_path / "a.mat", {"logs": logs})
    with pytest.raises(RecordingError, match="more than one column can be t"):
        read_recording(tmp_path / "a.mat")


@given(st.floats(-1e9, 1e9, allow_nan=False), st.sampled_from(",'\u00a0\u2009\u202f "))
def test_thousands_are_parted_and_joined(value, mark):
    text = f"{value:,.3f}".replace(",", mark)
    assert float(ungrouped(text)) == float(f"{value:.3f}")


@given(st.text(max_size=20))
def test_no_text_breaks_the_stamps(text):
    found = seconds([text, text, "12:00:00"])
    assert found is None or found.shape == (3,)


def test_seconds_and_nanoseconds_need_a_stem_that_says_time():
    columns = (RawColumn("runsecs", np.arange(3.0)), RawColumn("runnsecs", np.arange(3.0)))
    plain = RawTable(columns, np.arange(3))
    assert join_split(plain) is plain
