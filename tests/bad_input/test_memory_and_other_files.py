"""A small file that claims to be large is refused before anything is allocated; nothing but the file itself is read."""

import contextlib
import io
import struct
import tracemalloc
import zipfile
import zlib

import numpy as np
import pytest

from exoid.ground.errors import RecordingError
from exoid.measurement.reading import limits
from exoid.measurement.reading.limits import MOST_ENTRIES, Budget
from exoid.measurement.reading.read import read_recording
from tests.measurement.written import timetable

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


def element(kind, data, size=None):
    """An element of a MATLAB file; `size` is what it announces where that is not what it has."""
    return struct.pack("<II", kind, len(data) if size is None else size) + data + bytes(-len(data) % 8)


def array(kind, dims, *content, size=None):
    sizes = element(5, struct.pack(f"<{len(dims)}i", *dims))
    head = element(6, struct.pack("<II", kind, 0)) + sizes + element(1, b"q1")
    return element(14, head + b"".join(content), size)


def nested(depth):
    inner = array(6, (1, 1), element(9, bytes(8)))
    for _ in range(depth):
        inner = array(1, (1, 1), inner)
    return inner


NAMES = (element(5, struct.pack("<i", 8)), element(1, b"q1\0\0\0\0\0\0"))
UNSOUND = {
    "element longer than the file": array(6, (1, 9), element(9, bytes(72), 0xF0000000)),
    "variable longer than the file": array(6, (1, 9), element(9, bytes(72)), size=0xF0000000),
    "cells": array(1, (HUGE, 40), nested(0)),
    "cells of three dimensions": array(1, (2**20, 2**20, 2**20), nested(0)),
    "elements of a struct": array(2, (HUGE, 40), *NAMES, nested(0)),
    "struct without fields": array(2, (2**30, 2**30), NAMES[0], element(1, b"")),
    "struct with names of no length": array(2, (1, 1), element(5, bytes(4)), NAMES[1]),
    "text": array(4, (1, 2**31 - 1), element(16, b"")),
    "negative size": array(1, (-1, 3), nested(0)),
    "in a cell": array(1, (1, 1), array(6, (1, 9), element(9, bytes(72), 0xF0000000))),
    "cells in a struct": array(2, (1, 1), *NAMES, array(1, (HUGE, 40), nested(0))),
    "cells two thousand deep": nested(2000),
}


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("name", UNSOUND)
def test_matlab_that_announces_any_size(tmp_path, name, packed):
    """SciPy makes room for what is announced, and calls itself for what lies deeper."""
    body = element(15, zlib.compress(UNSOUND[name])) if packed else UNSOUND[name]
    (tmp_path / "run.mat").write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + body)
    refused(tmp_path / "run.mat", "announces|longer than|deep|length|negative|entries|GB")


def test_matlab_4_that_announces_any_size(tmp_path):
    for rows, columns in ((2**31 - 1, 2**31 - 1), (HUGE, 1), (HUGE // 8, 1), (-1, 1)):
        (tmp_path / "run.mat").write_bytes(struct.pack("<5i", 0, rows, columns, 0, 3) + b"q1\0" + bytes(80))
        refused(tmp_path / "run.mat", "longer than|impossible|GB")


def test_matlab_that_is_as_it_says_is_read(tmp_path):
    """Cells, structs in structs, texts, sparse, complex and empty arrays; packed or not."""
    import scipy.io
    import scipy.sparse

    cells = np.empty(3, dtype=object)
    cells[:] = ["hip", np.zeros((0, 3)), {"deep": {"deeper": [1, 2]}}]
    content = {"run": {"signals": COLUMNS}, "cells": cells, "text": "knee", "none": "", "z": np.ones(4) * 1j,
               "sparse": scipy.sparse.eye_array(5).tocsc(), "flag": np.array([True]), "i": np.int8([1, 2])}  # fmt: skip
    for packed in (False, True):
        scipy.io.savemat(tmp_path / "run.mat", content, do_compression=packed)
        np.testing.assert_allclose(read_recording(tmp_path / "run.mat").q[:, 0], COLUMNS["q1"])
    scipy.io.savemat(tmp_path / "run.mat", COLUMNS, format="4")
    np.testing.assert_allclose(read_recording(tmp_path / "run.mat").q[:, 0], COLUMNS["q1"])


def test_matlab_of_any_class_is_read_or_refused(tmp_path):
    """Every array said to be of another class: SciPy would follow indices that are none, and end the process."""
    import scipy.io
    import scipy.sparse

    path = tmp_path / "run.mat"
    few = {name: column[:200] for name, column in COLUMNS.items()}
    scipy.io.savemat(path, {**few, "sparse": scipy.sparse.eye_array(5).tocsc(), "run": {"text": "knee", "x": [1, 2]}})
    whole = path.read_bytes()
    flags = struct.pack("<II", 6, 8)
    places = [k + 8 for k in range(128, len(whole), 8) if whole[k : k + 8] == flags]
    assert len(places) == 9
    for place in places:
        for kind in (0, 1, 2, 3, 4, 5, 16, 17, 18, 255):
            path.write_bytes(whole[:place] + bytes([kind]) + whole[place + 1 :])
            with contextlib.suppress(RecordingError):
                read_recording(path)
    path.write_bytes(whole[: places[0]] + bytes([99]) + whole[places[0] + 1 :])
    refused(path, "class 99, which is unknown")


@pytest.mark.parametrize("rows", [1e9, np.nan])
def test_timetable_that_announces_any_number_of_rows(tmp_path, monkeypatch, rows):
    matio = pytest.importorskip("matio")
    path = tmp_path / "run.mat"
    timetable(path, {name: np.linspace(0.0, 1.0, 50) for name in ("t", "q1", "q2", "tau1", "tau2")})
    honest = matio.load_from_mat

    def lying(*where, raw_data=False, **options):
        assert raw_data, "converted before its rows were counted"
        content = honest(*where, raw_data=True, **options)
        content["run"].properties["any"][0, 0]["numRows"][...] = rows
        return content

    monkeypatch.setattr(matio, "load_from_mat", lying)
    with pytest.raises(RecordingError, match="more rows than it holds"):
        read_recording(path)


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


def test_two_cells_in_opposite_corners_of_a_sheet(tmp_path, monkeypatch):
    """Its reader asks for all cells between them, and ends its process where there is no room."""
    openpyxl = pytest.importorskip("openpyxl")
    pytest.importorskip("python_calamine")
    book = openpyxl.Workbook()
    book.active["A1"], book.active["XFD1048576"] = 1, 2
    book.save(tmp_path / "run.xlsx")
    refused(tmp_path / "run.xlsx", "damaged, or takes too much memory")
    book = openpyxl.Workbook()
    for row in range(100):
        book.active.append([float(row)] * 20)
    book.save(tmp_path / "run.xlsx")
    monkeypatch.setattr(limits, "MOST_BYTES", 100_000)
    refused(tmp_path / "run.xlsx")


def test_bag_that_claims_or_unpacks_to_any_size(tmp_path):
    pytest.importorskip("rosbags")
    from rosbags.rosbag1 import Writer

    writer = Writer(tmp_path / "run.bag")
    writer.set_compression(Writer.CompressionFormat.BZ2)
    with writer:
        digest = "992ce8a1687cec8c8bd883ec73ca41d1"
        line = writer.add_connection("/x", "std_msgs/msg/String", msgdef="string data\n", md5sum=digest)
        for k in range(3):
            writer.write(line, k, struct.pack("<I", MOST) + bytes(MOST))
    assert (tmp_path / "run.bag").stat().st_size < 20_000
    refused(tmp_path / "run.bag", "unpacks to more than")
    (tmp_path / "run.bag").write_bytes(b"#ROSBAG V2.0\n" + b"\xff\xff\xff\x7f" + bytes(100))
    refused(tmp_path / "run.bag", "damaged")
    head = b"\x89MCAP0\r\n\x01" + struct.pack("<Q", 2**60)
    (tmp_path / "run.mcap").write_bytes(head + bytes(60) + b"\x89MCAP0\r\n")
    refused(tmp_path / "run.mcap", "damaged")


def test_bag_whose_rows_are_computed(tmp_path):
    import sqlite3

    pytest.importorskip("rosbags")
    store = sqlite3.connect(tmp_path / "run.db3")
    store.execute("CREATE TABLE topics(id INTEGER, name TEXT, type TEXT, serialization_format TEXT)")
    store.execute(
        "CREATE VIEW messages AS WITH RECURSIVE c(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM c) "
        "SELECT id, 1 AS topic_id, id AS timestamp, zeroblob(100000000) AS data FROM c"
    )
    store.commit()
    store.close()
    refused(tmp_path / "run.db3", "computed, not recorded")


def test_tdms_that_claims_any_size(tmp_path):
    nptdms = pytest.importorskip("nptdms")
    path = tmp_path / "run.tdms"
    with nptdms.TdmsWriter(str(path)) as writer:
        writer.write_segment([nptdms.ChannelObject("leg", name, values) for name, values in COLUMNS.items()])
    data, count = path.read_bytes(), struct.pack("<Q", len(T))
    assert data.count(count) >= 5
    path.write_bytes(data.replace(count, struct.pack("<Q", 2**60)))
    refused(path, "GB|damaged|columns|samples")
