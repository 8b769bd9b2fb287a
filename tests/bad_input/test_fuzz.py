"""Damaged files of every kind: whatever is changed in them, they are read or refused, in bounded time.

Each round takes a good file, damages it at random and reads it. Rounds are the same in every run, each with a seed of
its own: `EXOID_FUZZ_ROUNDS` says how many (CI: a thousand, for a minute at most: `EXOID_FUZZ_SECONDS`),
`EXOID_FUZZ_FROM` with which one to begin, `EXOID_FUZZ_SEED` makes other ones. The file that failed is kept where the
message says.
"""

import io
import os
import random
import re
import sys
import tempfile
import time
import tracemalloc
import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest

from exoid.ground.errors import ExoidError
from exoid.measurement.bench.seal import Truth, open_seal, write_seal
from exoid.measurement.reading import limits
from exoid.measurement.reading.read import open_table, read_recording
from exoid.measurement.trajectories.trajectory import paper_trajectory
from exoid.measurement.trajectories.trajectory_file import read_trajectory, write_trajectory
from exoid.symbolic.model import Model, read_model
from exoid.symbolic.model_file import read_numbers, write_model

sys.path.insert(0, str(Path(__file__).parents[1] / "measurement"))
from written import FORMATS

SEED = int(os.environ.get("EXOID_FUZZ_SEED", "1"))
FIRST = int(os.environ.get("EXOID_FUZZ_FROM", "0"))
ROUNDS = int(os.environ.get("EXOID_FUZZ_ROUNDS", "40"))
SECONDS = float(os.environ.get("EXOID_FUZZ_SECONDS", "60"))
PATIENCE = 60.0
"""Seconds of processor time that one file may take, whatever else the machine does; a few milliseconds are usual."""
MEMORY = 400e6
T = np.arange(200) * 0.05
COLUMNS = {"t": T, "q1": np.sin(T), "q2": np.cos(1.3 * T), "tau1": 9 * np.sin(T), "tau2": 3 * np.cos(1.3 * T)}
EDGES = (b"\x00", b"\xff", b"\xff\xff\xff\xff", b"\x00\x00\x00\x80", b"\xff\xff\xff\x7f", b"\xff" * 8, b"\x00" * 16)
WORDS = (b"nan", b"inf", b"1e999", b"-", b'"', b"'", b"[", b"]]", b"{", b"=", b"\n", b"\r", b",", b"\t", b"#", b"\\",
         b"[[effects]]\n", b'id = "stribeck"\n', b"0x", b"1_0", b"true", b"**", b"(" * 50, b"exp(", b"\xc3\xa9",
         b"9" * 400, b"2024-01-01", b"12:00:00", b"/", b"../", b"<!DOCTYPE", b"__import__")  # fmt: skip
LEG = """name = "leg"
[geometry]
thigh_length = 0.4
[limits.hip]
angle = [-0.1, 1.2]
[[effects]]
id = "brake"
joint = "knee"
[[custom_effects]]
id = "brake"
joint = "knee"
torque = "c * tanh(dtheta / w) * play(theta, 0.1) + c * delay(theta2, 0.01)"
coefficients = { c = { unit = "N·m", min = 0 } }
shape = { w = { unit = "rad/s", min = 0.1, max = 1.0 } }
explains = "a brake"
"""
MAPPING = '[[recordings]]\nheader = ["t", "q1", "q2", "tau1", "tau2"]\ncolumns = { q1 = "q1" }\nunits = { q = "deg" }\n'


def undated(data: bytes) -> bytes:
    """The same file whenever it is made: some formats say when it was."""
    if data.startswith((b"MATLAB 5.0", b"MATLAB 7.3")):
        return data[:19].ljust(116) + data[116:]
    if not data.startswith(b"PK"):
        return data
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            new.writestr(zipfile.ZipInfo(name), re.sub(rb"20\d\d-[-\dT:]+Z", b"2020-01-01T00:00:00Z", old.read(name)))
    return out.getvalue()


def recordings() -> dict[str, bytes]:
    """A good file of every format that is written here, by its name."""
    import h5py
    import pandas
    import scipy.io

    frame = pandas.DataFrame(COLUMNS)
    made = {"a.csv": frame.to_csv(index=False).encode(), "b.tsv": frame.to_csv(index=False, sep="\t").encode()}
    made["c.txt"] = frame.to_csv(index=False, sep=";", decimal=",").encode()
    for name, write in (("d.npz", lambda s: np.savez_compressed(s, **COLUMNS)),
                        ("e.npz", lambda s: np.savez(s, **COLUMNS)),
                        ("f.mat", lambda s: scipy.io.savemat(s, COLUMNS)),
                        ("g.mat", lambda s: scipy.io.savemat(s, {"x": COLUMNS}, do_compression=True))):  # fmt: skip
        stream = io.BytesIO()
        write(stream)
        made[name] = undated(stream.getvalue())
    with tempfile.TemporaryDirectory() as folder:
        with h5py.File(Path(folder) / "h.h5", "w") as file:
            for name, values in COLUMNS.items():
                file.create_dataset(f"run/{name}", data=values, compression="gzip", chunks=(50,))
        made["h.h5"] = (Path(folder) / "h.h5").read_bytes()
        pyarrow = pytest.importorskip("pyarrow") if not os.environ.get("EXOID_FUZZ_LEAN") else None
        if pyarrow:
            frame.to_parquet(Path(folder) / "i.parquet")
            made["i.parquet"] = (Path(folder) / "i.parquet").read_bytes()
        for name, write in FORMATS.items():
            path = Path(folder) / name
            try:
                write(path, COLUMNS)
            except pytest.skip.Exception:
                continue  # its package is not installed
            for file in sorted(path.glob("*.db3")) + sorted(path.glob("*.mcap")) if path.is_dir() else [path]:
                made[f"{len(made)}{file.suffix}"] = undated(file.read_bytes())
    return made


def read_both(path):
    """A model file for what is in it, and for its identified parameters."""
    read_model(path)
    read_numbers(path)


def mapped(path):
    """A mapping, through the recording it is about."""
    path.rename(path.with_name("exoid.toml"))
    (path.parent / "a.csv").write_bytes(GOOD["a.csv"][0])
    read_recording(path.parent / "a.csv")


def texts() -> dict[str, tuple[bytes, object]]:
    """Good files of the other kinds, with what reads them."""
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        write_model(Model().with_effect("stribeck", "hip"), here / "model")
        write_trajectory(paper_trajectory(), here / "motion")
        (here / "run").write_text("x")
        write_seal(here / "seal", Truth("leg", (1.0,) * 8, (), 1), [here / "run"])
        return {
            "model.toml": ((here / "model").read_bytes(), read_both), "own.toml": (LEG.encode(), read_both),
            "motion.toml": ((here / "motion").read_bytes(), read_trajectory),
            "truth.seal": ((here / "seal").read_bytes(), open_seal), "mapping.toml": (MAPPING.encode(), mapped),
        }  # fmt: skip


GOOD = {name: (data, read_recording) for name, data in recordings().items()} | texts()


def damaged(rng: random.Random, data: bytes) -> bytes:
    """Return `data` after one to six changes."""
    out = bytearray(data)
    for _ in range(rng.randint(1, 6)):
        at = rng.randrange(len(out) + 1)
        kind = rng.randrange(8)
        if kind == 0 and out:
            out[at % len(out)] ^= 1 << rng.randrange(8)
        elif kind == 1:
            del out[at:]
        elif kind == 2:
            edge = rng.choice(EDGES)
            out[at : at + len(edge)] = edge
        elif kind == 3:
            out[at:at] = rng.choice(WORDS)
        elif kind == 4:
            out[at:at] = out[at : at + rng.randint(1, 400)]
        elif kind == 5:
            del out[at : at + rng.randint(1, 60)]
        elif kind == 6:
            out[at : at + 8] = rng.randbytes(8)
        else:
            word = rng.choice(WORDS)
            out[at : at + len(word)] = word
    return bytes(out)


@pytest.mark.slow
def test_damaged_files_are_read_or_refused(tmp_path, monkeypatch):
    """Nothing else escapes, nothing takes long, and nothing takes more memory than a reader may ask for."""
    monkeypatch.setattr(limits, "MOST_BYTES", 50_000_000)
    ends = time.monotonic() + SECONDS
    tracemalloc.start()
    try:
        for number in range(FIRST, FIRST + ROUNDS):
            if time.monotonic() > ends and number >= FIRST + 50:
                break
            rng = random.Random(SEED * 1_000_003 + number)
            name = rng.choice(list(GOOD))
            data, read = GOOD[name]
            folder = tmp_path / str(number)
            folder.mkdir()
            path = folder / name
            path.write_bytes(damaged(rng, data))
            before, began = path.read_bytes(), time.process_time()
            tracemalloc.reset_peak()
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                try:
                    read(path)
                except ExoidError as error:
                    assert str(error)
                except BaseException as error:  # noqa: BLE001 - whatever it is
                    pytest.fail(f"{type(error).__name__}: {error}; seed {SEED}, round {number}, kept as {path}")
            seconds, memory = time.process_time() - began, tracemalloc.get_traced_memory()[1]
            assert seconds < PATIENCE and memory < MEMORY, (seconds, memory, SEED, number, path)
            for left in folder.iterdir():
                if left.name == name:
                    assert left.read_bytes() == before
                left.unlink()
            folder.rmdir()
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("name", list(GOOD))
def test_the_files_are_good_before(name, tmp_path):
    data, read = GOOD[name]
    (tmp_path / name).write_bytes(data)
    if read is read_recording:
        assert len(open_table(tmp_path / name).columns) >= 5
    read(tmp_path / name)
