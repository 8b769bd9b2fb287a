"""Every kind of file people hand in gives the same recording."""

import codecs
import sys

import h5py
import numpy as np
import pandas as pd
import pytest
import scipy.io
from tables import HEADER, leg, lines, text

from exoid.ground.errors import ExoidError, RecordingError
from exoid.measurement.bench.simulation import Bench, simulate
from exoid.measurement.reading.formats import csv
from exoid.measurement.reading.read import read_recording
from exoid.measurement.recording import to_csv, write_recording

LEG = leg()
Q = np.column_stack([LEG["q1"], LEG["q2"]])
TAU = np.column_stack([LEG["tau1"], LEG["tau2"]])
ROWS = lines()
TEXTS = {
    "plain.csv": text().encode(),
    "semicolon_decimal_comma.csv": text(sep=";", decimal=",").encode(),
    "tab.tsv": text(sep="\t").encode(),
    "tab_decimal_comma.txt": text(sep="\t", decimal=",").encode(),
    "blanks.dat": text(sep="   ").encode(),
    "bom.csv": codecs.BOM_UTF8 + text().encode(),
    "utf16.csv": text(sep=";", decimal=",").encode("utf-16"),
    "utf16_without_bom.csv": text().encode("utf-16-le"),
    "latin.csv": text(header="t [s],q1 [rad],q2 [rad],tau1 [N·m],tau2 [N·m]").encode("latin-1"),
    "crlf.csv": text(eol="\r\n").encode(),
    "old_mac.csv": text(eol="\r").encode(),
    "excel_sep.csv": ("sep=,\n" + text()).encode(),
    "savetxt.txt": ("# " + text()).encode(),
    "preamble.log": ("% Logger 3.1\nDate: 2022-08-15\nOperator: A. B.\n\n" + text(sep=";")).encode(),
    "unit_row.csv": text(units="[s],[rad],[rad],[Nm],[Nm]").encode(),
    "trailing_comma.csv": text().replace("\n", ",\n").encode(),
    "blank_lines.csv": text().replace("\n", "\n\n").encode(),
    "comments_inside.csv": "\n".join([*ROWS[:50], "# pause", *ROWS[50:]]).encode(),
    "quoted.csv": "\n".join(",".join(f'"{c}"' for c in row.split(",")) for row in ROWS).encode(),
    "quoted_decimal_comma.csv": "\n".join(
        ",".join(f'"{c.replace(".", ",")}"' for c in row.split(",")) for row in ROWS
    ).encode(),
    "spaces_after_comma.csv": text().replace(",", ", ").encode(),
    "upper.CSV": text(header="Time,Hip Angle,kneeAngle,HIP_TORQUE,torque_knee").encode(),
    "units_in_names.csv": text(header="time_s,hip_angle_rad,q2 (rad),tau1_Nm,tau2 [N m]").encode(),
    "extra_columns.csv": "\n".join(
        [HEADER + ",comment,q1_ref", *(f"{row},swing,{i}" for i, row in enumerate(ROWS[1:]))]
    ).encode(),
}


@pytest.mark.parametrize("name", TEXTS)
def test_text_tables_read_alike(name, tmp_path):
    path = tmp_path / name
    path.write_bytes(TEXTS[name])
    recording = read_recording(path)
    assert len(recording) == len(Q) and recording.valid.all()
    np.testing.assert_allclose(recording.q, Q, atol=1e-8)
    np.testing.assert_allclose(recording.tau, TAU, rtol=1e-7, atol=1e-7)
    assert path.read_bytes() == TEXTS[name]
    assert not [f for f in recording.findings if f.severity in ("warning", "repaired")]


def _npz(path):
    np.savez(path, t=LEG["t"], q=Q, tau=TAU.T, rate=100.0, note="x")


def _structured_npz(path):
    np.savez(path, run=np.rec.fromarrays(list(LEG.values()), names=list(LEG)))


def _mat(path):
    run = {"time": LEG["t"], "hip": {"angle": LEG["q1"]}, "q2": LEG["q2"], "tau": TAU, "rate": 100.0}
    scipy.io.savemat(path, {"run": run})


def _mat_matrix_with_names(path):
    names = np.array(["t", "q1 [rad]", "q2", "tau1", "tau2"], dtype=object)
    scipy.io.savemat(path, {"run": {"data": np.column_stack(list(LEG.values())), "names": names}})


def _mat_struct_array(path):
    kinds = [(name, "O") for name in LEG]
    scipy.io.savemat(path, {"run": np.array(list(zip(*LEG.values(), strict=True)), dtype=kinds)})


def _hdf5(path):
    with h5py.File(path, "w") as file:
        group = file.create_group("leg/run1")
        group["time"] = LEG["t"]
        group.create_dataset("q1", data=np.degrees(LEG["q1"])).attrs["unit"] = "deg"
        group["q2"] = LEG["q2"][:, None]
        file["tau"] = TAU


def _mat73(path):
    """A struct saved by MATLAB 7.3: HDF5 behind a text header, arrays transposed, names in a cell of references."""
    with h5py.File(path, "w", userblock_size=512) as file:
        file.create_group("#refs#")
        group = file.create_group("run")
        group["data"] = np.column_stack(list(LEG.values())).T
        cells = []
        for i, name in enumerate(LEG):
            file[f"#refs#/{i}"] = np.array([[ord(c)] for c in name], dtype=np.uint16)
            file[f"#refs#/{i}"].attrs["MATLAB_class"] = np.bytes_("char")
            cells.append(file[f"#refs#/{i}"].ref)
        group.create_dataset("names", data=np.array([cells], dtype=h5py.ref_dtype)).attrs["MATLAB_class"] = np.bytes_(
            "cell"
        )
    with path.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(128))


def _parquet(path):
    pytest.importorskip("pyarrow")
    pd.DataFrame(LEG).rename(columns={"q1": "q1 [rad]"}).to_parquet(path)


BINARIES = {
    "a.npz": _npz, "b.npz": _structured_npz, "a.mat": _mat, "b.mat": _mat_matrix_with_names, "c.mat": _mat_struct_array,
    "d.mat": _mat73, "a.h5": _hdf5, "a.parquet": _parquet,
}  # fmt: skip


@pytest.mark.parametrize("name", BINARIES)
def test_binary_formats_read_alike_and_break_politely(name, tmp_path):
    path = tmp_path / name
    BINARIES[name](path)
    recording = read_recording(path)
    np.testing.assert_allclose(recording.q, Q, atol=1e-12)
    np.testing.assert_allclose(recording.tau, TAU)
    whole = path.read_bytes()
    for keep in (0.9, 0.5, 0.1):
        path.write_bytes(whole[: int(keep * len(whole))])
        with pytest.raises(RecordingError):
            read_recording(path)


def test_written_recordings_read_back_exactly(tmp_path):
    (tmp_path / "a.csv").write_text(text().replace("0.01,", "0.01,oops", 1))
    first = read_recording(tmp_path / "a.csv")
    assert not first.complete.all()
    again = read_recording(write_recording(first, tmp_path / "new" / "b.csv"))
    np.testing.assert_array_equal(first.t, again.t)
    for valid, values in (("angle_valid", "q"), ("torque_valid", "tau")):
        mask = getattr(first, valid)
        np.testing.assert_array_equal(mask, getattr(again, valid))
        np.testing.assert_array_equal(getattr(first, values)[mask], getattr(again, values)[mask])
    assert to_csv(first) == to_csv(again)
    assert [p.name for p in (tmp_path / "new").iterdir()] == ["b.csv"]


def test_exactness_of_digits(tmp_path):
    rng = np.random.default_rng(5)
    columns = leg()
    columns["tau1"] = columns["tau1"] * rng.standard_normal(len(Q)) * 1e-3
    rows = "\n".join(",".join(map(repr, row)) for row in zip(*(c.tolist() for c in columns.values()), strict=True))
    (tmp_path / "a.csv").write_text(HEADER + "\n" + rows)
    np.testing.assert_array_equal(read_recording(tmp_path / "a.csv").tau[:, 0], columns["tau1"])


@pytest.mark.parametrize(
    "text",
    [
        "t,q1,q2,tau1,tau2\n" + "".join(f"{k / 10},{k % 7 / 9:.12f},1e-3,-2,{k}\n" for k in range(40)),
        "t;q1;q2;tau1;tau2\n" + "".join(f"{k / 10};{k % 7};;x;1.234,5\n".replace(".", ",", 1) for k in range(40)),
        "t,q1,q2,tau1,tau2\n" + "".join(f"2024-01-01T10:00:{k:02}.25Z,{k},{k or 'NA'},2,{k}\n" for k in range(40)),
        "t q1 q2 tau1 tau2\n" + "".join(f"{k / 10} {k} nan -inf {k}\n" for k in range(40)),
    ],
)
def test_a_text_is_read_alike_with_pandas_and_without(text, tmp_path, monkeypatch):
    (tmp_path / "run.csv").write_text(text)
    monkeypatch.setattr(csv, "SHORT", 0)
    quick = csv.read(tmp_path / "run.csv")
    monkeypatch.setitem(sys.modules, "pandas", None)
    plain = csv.read(tmp_path / "run.csv")
    assert [(c.name, c.unit, c.texts) for c in plain.columns] == [(c.name, c.unit, c.texts) for c in quick.columns]
    for one, other in zip(plain.columns, quick.columns, strict=True):
        assert np.array_equal(one.values, other.values, equal_nan=True)


def test_who_asks_for_a_data_frame_without_pandas_is_told_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ExoidError, match=r"pip install 'exoid\[pandas\]'"):
        simulate(bench=Bench(duration=5.0)).to_frame()
