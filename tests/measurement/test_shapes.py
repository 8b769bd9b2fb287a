"""Tables of other shapes: one value a row, and lists in cells, as loggers and data sets of robots have them."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from exoid.ground.errors import RecordingError
from exoid.measurement.reading.read import open_table, read_recording, read_recordings
from exoid.symbolic.joints import Joint

T = np.arange(800) * 0.01
Q = np.column_stack([np.sin(T), np.sin(1.3 * T)])
TAU = np.column_stack([3 * np.cos(T), 2 * np.cos(1.3 * T)])
ARM = (Joint("arm", length=1.0),)


def long_rows():
    """(time, key, value) of an arm: its torque a third of a step later, and now and then a word."""
    rows = [(t, "NT:/arm/position", f"{q:.6f}") for t, q in zip(T, Q[:, 0], strict=True)]
    rows += [(t, "NT:/arm/torque", f"{3 * np.cos(t):.6f}") for t in T + 0.003]
    rows += [(t + 0.004, "NT:/arm/state", "forward") for t in T[::200]]
    return sorted(rows)


@pytest.mark.parametrize("name", ["log.csv", "semicolon.csv", "log.pq"])
def test_keys_become_columns_on_one_clock(name, tmp_path):
    path = tmp_path / name
    if path.suffix == ".csv":
        lines = [("Timestamp", "Key", "Value"), *long_rows()]
        text = "\n".join(",".join(map(str, row)) for row in lines)
        path.write_text(text.replace(",", ";" if name.startswith("semi") else ","), encoding="utf-8")
    else:
        pytest.importorskip("pyarrow")
        pd.DataFrame(long_rows(), columns=["t", "Name", "Wert"]).to_parquet(path)
    found = read_recording(path, joints=ARM)
    assert np.allclose(found.q[:, 0], Q[:, 0], atol=1e-5)
    assert np.allclose(found.tau[1:, 0], TAU[1:, 0], atol=1e-3)  # on the instants of the angle, not on its own
    assert any("keys" in finding.what for finding in found.findings)


def test_a_key_that_is_nothing_of_the_machine_is_asked_by_its_name(tmp_path):
    rows = [(t, key.replace("position", "foo"), value) for t, key, value in long_rows()]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["t,key,value", *(",".join(map(str, row)) for row in rows), ""]), encoding="utf-8")
    with pytest.raises(RecordingError, match="NT:/arm/foo") as error:
        read_recording(path, joints=ARM)
    assert "no columns of numbers: NT:/arm/state" in str(error.value)
    assert read_recording(path, {"q1": "NT:/arm/foo"}, joints=ARM).q.shape[1] == 1


@pytest.mark.parametrize("fixed", [False, True])
def test_lists_become_a_column_for_each_element(fixed, tmp_path):
    pa = pytest.importorskip("pyarrow")
    from pyarrow import parquet

    state = [[float(x) for x in row] for row in Q]
    kind = pa.list_(pa.float64(), 2) if fixed else pa.list_(pa.float64())
    columns = {
        "timestamp": pa.array(T),
        "observation.state": pa.array(state, kind),
        "observation.effort": pa.array([[float(x) for x in row] for row in TAU]),
        "action": pa.array([[1.0, 2.0]] * T.size),
        "observation.image": pa.array([{"path": "a.mp4", "timestamp": t} for t in T]),
        "tags": pa.array([[1.0] * (k % 3) for k in range(T.size)]),
    }
    path = tmp_path / "episode_0.parquet"
    parquet.write_table(pa.table(columns), path)
    names = open_table(path).names
    assert {"observation.state_0", "observation.state_1", "action_0", "observation.effort_1"} <= set(names)
    with pytest.raises(RecordingError) as error:
        read_recording(path)
    assert "observation.state_0" in str(error.value) and "observation.image, tags" in str(error.value)
    told = {"q1": "observation.state_0", "q2": "observation.state_1"}
    told |= {"tau1": "observation.effort_0", "tau2": "observation.effort_1"}
    found = read_recording(path, told)
    assert np.allclose(found.q, Q) and np.allclose(found.tau, TAU)
    in_pieces = read_recordings(path, told, most_bytes=20_000)
    assert np.allclose(in_pieces[0].q[:100], Q[:100])
    in_memory = read_recording(pd.read_parquet(path).drop(columns=["tags", "observation.image"]), told)
    assert np.allclose(in_memory.q, Q)


@pytest.mark.parametrize(
    "header",
    [
        "time,topic,measurement", "Zeit;Kanal;Wert", "time,channel,value", "timestamp,name,val", "Time [s],Signal,Data",
        "time,sensor_id,float_value", "tiempo,señal,valor", "t,was,wieviel", "time,signal,value,unit",
        "time,host,_field,_measurement,_value",
    ],
)  # fmt: skip
def test_tables_with_one_value_a_row_have_any_headings(header, tmp_path):
    mark = ";" if ";" in header else ","
    names = header.split(mark)
    rows = [header]
    for t, q, tau in zip(T, Q[:, 0], TAU[:, 0], strict=True):
        for key, value, unit in (("position", np.degrees(q), "deg"), ("torque", 1000 * tau, "mNm")):
            if "unit" not in names:
                value = np.radians(value) if unit == "deg" else value / 1000
            words = {"_measurement": "motor", "host": "pi", "unit": unit}
            cells = [f"{t:.4f}", key, f"{value:.7g}"]
            rows.append(mark.join(words.get(name) or cells.pop(0) for name in names))
    (tmp_path / "run.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    found = read_recording(tmp_path / "run.csv", joints=ARM)
    assert np.allclose(found.q[:, 0], Q[:, 0], atol=1e-5) and np.allclose(found.tau[:, 0], TAU[:, 0], atol=1e-4)


def test_the_state_of_a_machine_is_no_key(tmp_path):
    rows = [f"{t:.2f},{'walk' if t % 4 < 2 else 'stand'},{x:.5f}" for t, x in zip(T, Q[:, 0], strict=True)]
    (tmp_path / "run.csv").write_text("\n".join(["t,mode,knob", *rows, ""]), encoding="utf-8")
    assert open_table(tmp_path / "run.csv").names == ["t", "mode", "knob"]


@pytest.mark.parametrize("header", ["t,q1_desired,q2_desired,tau1_cmd,tau2_cmd", "t,Soll_q1,Soll_q2,tau1_ref,tau2_ref"])
def test_files_of_set_points_alone_are_named_as_that(header, tmp_path):
    np.savetxt(tmp_path / "run.csv", np.column_stack([T, Q, TAU]), delimiter=",", header=header, comments="")
    with pytest.raises(RecordingError, match="only set-points: ") as error:
        read_recording(tmp_path / "run.csv")
    assert "--map" not in error.value.remedy and "COLUMN" not in error.value.remedy
