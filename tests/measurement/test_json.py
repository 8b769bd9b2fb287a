"""Logs in JSON: one record per line, a list of them, an object of columns, and what pandas writes."""

from __future__ import annotations

import json
import zipfile

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tables import leg

from exoid.ground.errors import RecordingError
from exoid.measurement.reading.formats.json import read
from exoid.measurement.reading.read import read_recording, read_recordings

LEG = leg(200)
COLUMNS = {name: values.tolist() for name, values in LEG.items()}
RECORDS = [dict(zip(COLUMNS, row, strict=True)) for row in zip(*COLUMNS.values(), strict=True)]
NESTED = [{"t": r["t"], "q": [r["q1"], r["q2"]], "hip": {"torque": r["tau1"]}, "knee": {"torque": r["tau2"]}}
          for r in RECORDS]  # fmt: skip
GROUPS = {"t": COLUMNS["t"], **{joint: {"angle": COLUMNS[f"q{k}"], "torque": COLUMNS[f"tau{k}"]}
                                for k, joint in ((1, "hip"), (2, "knee"))}}  # fmt: skip
MATRICES = {"time": COLUMNS["t"], "q_deg": np.degrees(np.column_stack([LEG["q1"], LEG["q2"]])).tolist(),
            "tau": np.column_stack([LEG["tau1"], LEG["tau2"]]).tolist(), "device": "bench 3"}  # fmt: skip
FRAME = pd.DataFrame(LEG)


def by_line(records):
    return "".join(json.dumps(record) + "\n" for record in records)


@pytest.mark.parametrize(
    "text",
    [
        json.dumps(RECORDS), json.dumps(RECORDS, indent=1), json.dumps(COLUMNS), by_line(RECORDS), by_line(NESTED),
        json.dumps({"meta": {"subject": "s1"}, "units": {"q1": "rad"}, "data": NESTED}), json.dumps(GROUPS),
        json.dumps({"log": GROUPS}), json.dumps(MATRICES),
        json.dumps([[*COLUMNS], *(list(r.values()) for r in RECORDS)]),
        by_line([{"event": "start", "device": "bench"}, *RECORDS]), "\ufeff" + json.dumps(RECORDS),
        *(FRAME.to_json(orient=orient, double_precision=15) for orient in
          ("records", "split", "columns", "index", "table")),
    ],
)  # fmt: skip
def test_a_log_is_read_however_it_is_laid_out(text, tmp_path):
    path = tmp_path / "run.json"
    path.write_text(text, encoding="utf-8")
    recording = read_recording(path)
    np.testing.assert_allclose(recording.t, LEG["t"], atol=1e-9)
    np.testing.assert_allclose(recording.q, np.column_stack([LEG["q1"], LEG["q2"]]), atol=1e-9)
    np.testing.assert_allclose(recording.tau, np.column_stack([LEG["tau1"], LEG["tau2"]]), atol=1e-9)


def test_it_is_known_by_its_content_and_its_rows_are_lines(tmp_path):
    path = tmp_path / "run.log"
    rows = [dict(record) for record in RECORDS]
    rows[7]["tau1"] = "overflow"
    path.write_text("\n" + by_line(rows).replace("\n", "\n\n"), encoding="utf-8")
    with pytest.raises(RecordingError):
        read_recording(path)  # a blank line first: it does not begin as JSON does
    path.write_text(by_line(rows), encoding="utf-8")
    recording = read_recording(path)
    assert recording.row[~recording.torque_valid[:, 0]].tolist() == [8]


def test_units_beside_the_table_count(tmp_path):
    path = tmp_path / "run.json"
    small = {**COLUMNS, "q1": (0.01 * np.degrees(LEG["q1"])).tolist()}
    path.write_text(json.dumps({"units": {"q1": "deg"}, "samples": small}), encoding="utf-8")
    np.testing.assert_allclose(read_recording(path).q[:, 0], 0.01 * LEG["q1"])


def test_a_line_that_was_cut_off_is_left_out_and_it_is_said(tmp_path):
    path = tmp_path / "run.jsonl"
    path.write_text(by_line(RECORDS)[:-30], encoding="utf-8")
    recording = read_recording(path)
    assert len(recording) == len(RECORDS) - 1
    assert any("cut off" in finding.what for finding in recording.findings)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('{"t": [1, 2', "not JSON"),
        ("", "not JSON"),
        ("[" * 100_000, "not JSON"),
        (by_line(RECORDS[:5]) + "{oops}\n" + by_line(RECORDS[5:]), "line 6"),
        (json.dumps({"port": 3, "gains": [1, 2, 3]}), "holds no table"),
        (json.dumps({"schema": "exoid.discovery/1", "steps": RECORDS}), "a result of exoid"),
        ('{"t": ' + "9" * 5000 + "}", "JSON"),
    ],
)
def test_what_is_no_log_is_refused_in_words(text, words, tmp_path):
    path = tmp_path / "run.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(RecordingError, match=words):
        read_recording(path)


def test_settings_and_results_in_a_folder_of_recordings_are_none(tmp_path):
    (tmp_path / "run.jsonl").write_text(by_line(RECORDS), encoding="utf-8")
    (tmp_path / "config.json").write_text('{"rate": 100}', encoding="utf-8")
    (tmp_path / "result.json").write_text(json.dumps({"schema": "exoid.discovery/1", "x": RECORDS}), encoding="utf-8")
    with zipfile.ZipFile(tmp_path / "all.zip", "w") as archive:
        for file in sorted(tmp_path.glob("*.json*")):
            archive.write(file, file.name)
    assert [one.name for one in read_recordings(tmp_path)] == ["run"]
    assert len(read_recordings(tmp_path / "all.zip")) == 1
    (tmp_path / "config.json").write_text('{"rate": 100', encoding="utf-8")
    with pytest.raises(RecordingError, match="not JSON"):  # it might have been one
        read_recordings(tmp_path)


CELLS = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=12) | st.dictionaries(st.text(max_size=4), inner, max_size=4),
    max_leaves=30,
)


@pytest.mark.slow
@given(st.lists(st.dictionaries(st.sampled_from(["t", "q", "a"]), CELLS), min_size=10, max_size=12) | CELLS)
def test_no_json_ends_in_a_traceback(tmp_path_factory, value):
    path = tmp_path_factory.mktemp("json") / "any.json"
    path.write_text(json.dumps(value), encoding="utf-8")
    try:
        table = read(path)
    except RecordingError as error:
        assert error.remedy
    else:
        assert all(column.values.shape == table.row.shape for column in table.columns)
