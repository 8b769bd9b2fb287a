"""A small file that claims to be large is refused before anything is allocated; nothing but the file itself is read."""

import io
import struct
import tracemalloc
import zipfile
import zlib

import numpy as np
import pytest

from ground.errors import RecordingError
from measurement.reading import limits
from measurement.reading.limits import MOST_ENTRIES, Budget
from measurement.reading.read import read_recording

T = np.arange(2000) * 0.01
COLUMNS = {"t": T, "q1": np.sin(T), "q2": np.cos(1.3 * T), "tau1": 9 * np.sin(T), "tau2": 3 * np.cos(1.3 * T)}
MOST = 20_000_000
HUGE = 10**7


@pytest.fixture(autouse=True)
def smaller(monkeypatch):
    """A hundredth of the bound, so that the test is as quick as the refusal."""
    monkeypatch.setattr(limits, "MOST_BYTES", MOST)


def refused(path, words=r"GB|entries|other files"):
    """What is refused takes next to no memory on the way there."""
    before = path.read_bytes()
    tracemalloc.start()
    try:
        with pytest.raises(RecordingError, match=words):
            read_recording(path)
        assert tracemalloc.get_traced_memory()[1] < 0.9 * MOST
    finally:
        tracemalloc.stop()
    assert path.read_bytes() == before


def test_hdf5_that_claims_any_size(tmp_path):
    import h5py

    cases = {
        "one": {"shape": (HUGE,), "dtype": "f8", "chunks": (1000,)},
        "wide cells": {"shape": (1000,), "dtype": np.dtype((np.void, 100_000)), "chunks": (1,)},
        "two columns": {"shape": (HUGE, 2), "dtype": "i1", "chunks": (1000, 2)},
        "texts": {"shape": (HUGE,), "dtype": h5py.string_dtype(), "chunks": (1000,)},
    }
    for name, options in cases.items():
        path = tmp_path / f"{name}.h5"
        with h5py.File(path, "w") as file:
            file.create_dataset("q1", compression="gzip", **options)
        assert path.stat().st_size < 100_000
        refused(path)
    with h5py.File(tmp_path / "many.h5", "w") as file:
        for k in range(30):  # none is too large alone
            file.create_dataset(f"x{k}", shape=(HUGE // 50,), dtype="f8", chunks=(1000,), compression="gzip")
    refused(tmp_path / "many.h5")


@pytest.mark.parametrize("kind", ["virtual", "external storage", "external link", "soft link", "virtual in a group"])
def test_hdf5_reads_no_other_file(tmp_path, kind):
    import h5py

    secret = tmp_path / "secret.bin"
    secret.write_bytes(COLUMNS["tau2"].tobytes())
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["tau2"] = COLUMNS["tau2"]
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        for name, values in COLUMNS.items():
            if name != "tau2":
                file[name] = values
        if kind.startswith("virtual"):
            layout = h5py.VirtualLayout(shape=T.shape, dtype="f8")
            layout[:] = h5py.VirtualSource(tmp_path / "other.h5", "tau2", shape=T.shape)
            file.create_virtual_dataset("deep/tau2" if "group" in kind else "tau2", layout)
        elif kind == "external storage":
            file.create_dataset("tau2", shape=T.shape, dtype="f8", external=[(str(secret), 0, T.size * 8)])
        elif kind == "external link":
            file["tau2"] = h5py.ExternalLink(str(tmp_path / "other.h5"), "/tau2")
        else:
            file["tau2"] = h5py.SoftLink("/nowhere")
    with pytest.raises(RecordingError, match=r"other files|tau2 was found"):
        read_recording(path)


def test_matlab_73_references_read_no_other_file(tmp_path):
    import h5py

    path = tmp_path / "run.mat"
    (tmp_path / "secret").write_bytes(b"secret" * 100)
    with h5py.File(path, "w", userblock_size=512) as file:
        hidden = file.create_dataset("#refs#/a", shape=(20,), dtype="u2", external=[(str(tmp_path / "secret"), 0, 40)])
        file["x"] = np.zeros((2, 5))
        file.create_dataset("names", data=np.array([hidden.ref] * 2, dtype=h5py.ref_dtype))
        file["names"].attrs["MATLAB_class"] = np.bytes_("cell")
    with path.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
    with pytest.raises(RecordingError) as caught:
        read_recording(path)
    assert "secret" not in str(caught.value).replace(str(tmp_path), "") and "\u6573" not in str(caught.value)


def npy(shape, data=b"", kind="<f8"):
    head = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}"
    head = head.ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(head)) + head.encode() + data


def test_npz_that_claims_or_unpacks_to_any_size(tmp_path):
    path = tmp_path / "claims.npz"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("t.npy", npy(f"({HUGE},)", bytes(80)))
    refused(path)
    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("t.npy", "w") as stream:
        stream.write(npy("(125000,)"))
        stream.write(bytes(1_000_000))
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        for name in ("q1", "q2"):
            archive.writestr(f"{name}.npy", npy(f"({HUGE // 5},)"))
    assert path.stat().st_size < 200_000
    refused(path)
    for shape in ("(-1,)", f"({10**30},)", "(1, " * 40 + ")", "__import__('os')"):
        with zipfile.ZipFile(tmp_path / "odd.npz", "w") as archive:
            archive.writestr("t.npy", npy(shape))
        with pytest.raises(RecordingError):
            read_recording(tmp_path / "odd.npz")


def test_matlab_that_unpacks_to_any_size(tmp_path):
    path = tmp_path / "bomb.mat"
    pack = zlib.compressobj(9)
    packed = io.BytesIO()
    cells = HUGE // 4
    head = struct.pack("<8I", 6, 8, 6, 0, 5, 8, 1, cells) + struct.pack("<II", 1, 1) + b"t" + bytes(7)
    packed.write(
        pack.compress(struct.pack("<II", 14, (8 * cells + 56) % 2**32) + head + struct.pack("<II", 9, 21_000_000))
    )
    for _ in range(21):
        packed.write(pack.compress(bytes(1_000_000)))
    packed.write(pack.flush())
    data = packed.getvalue()
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + struct.pack("<II", 15, len(data)) + data)
    assert path.stat().st_size < 3e6
    refused(path)


def test_parquet_that_claims_any_size(tmp_path):
    arrow = pytest.importorskip("pyarrow")
    from pyarrow import parquet

    one = arrow.array(np.zeros(100_000))
    path = tmp_path / "repeated.parquet"
    with parquet.ParquetWriter(path, arrow.schema([("t", "f8"), ("q1", "f8")])) as writer:
        for _ in range(15):
            writer.write_table(arrow.table({"t": one, "q1": one}), row_group_size=100_000)
    assert path.stat().st_size < 1e6
    refused(path)
    path = tmp_path / "texts.parquet"
    cells = arrow.array(["x" * 10_000_001] * 3)
    table = arrow.table({"t": arrow.array(np.zeros(3)), "note": cells.dictionary_encode().cast("large_string")})
    parquet.write_table(table, path, use_dictionary=True, compression="zstd")
    assert path.stat().st_size < 1e6
    refused(path)


def test_wide_and_long_lines(tmp_path):
    path = tmp_path / "wide.csv"
    names = ",".join(f"c{k}" for k in range(MOST_ENTRIES + 1))
    path.write_text(names + "\n" + ",".join("1" for _ in range(MOST_ENTRIES + 1)) + "\n")
    with pytest.raises(RecordingError):
        read_recording(path)
    path = tmp_path / "sparse.csv"
    with path.open("wb") as stream:
        stream.write(b"t,q1,q2,tau1,tau2\n")
        stream.truncate(MOST)
    with pytest.raises(RecordingError, match="GB"):
        read_recording(path)


def test_a_budget_is_one_for_the_whole_file():
    budget = Budget("x")
    for _ in range(4):
        budget.take(MOST / 5)
    with pytest.raises(RecordingError, match=r"0\.024 GB"):
        budget.take(2 * MOST / 5)
    for size in (1e300, float("inf"), 10**40):
        with pytest.raises(RecordingError, match="GB"):
            Budget("x").take(size)
