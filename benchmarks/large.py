"""An hour at 1 kHz through reading, preparing, fitting, `exoid compare` and `exoid discover`: seconds, peak memory.

    python benchmarks/large.py [--minutes 60] [--formats csv npz h5] [--discover]
    python benchmarks/large.py --hours 24 [--formats csv parquet] [--keep FOLDER]

The recording is a minute of the virtual bench (a periodic motion, so that the copies join), repeated, with sensor noise
of its own in every copy. Each stage runs in a process of its own, because peak memory never goes down within one; its
figure contains the interpreter, the libraries and the stages before it. Nothing is asserted.

With `--hours` numbers are written in full, 90 bytes a row, so that a day is 8 GB of text; it is audited and its
stretches are chosen piece by piece, in bounded memory.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402 - the number of threads must be set first

RATE, PERIOD = 1000.0, 10.0
STAGES = ("import", "read", "prepare", "identify", "compare")


def write(folder: Path, minutes: int, formats: list[str]) -> None:
    """Write the recording in each format; text goes out a minute at a time."""
    from exoid.measurement.bench.sensors import Sensors
    from exoid.measurement.bench.simulation import Bench, run_bench
    from exoid.measurement.trajectories.trajectory import random_trajectory

    path = random_trajectory(np.random.default_rng(3), period=PERIOD)
    true = run_bench(excitation=path, bench=Bench(duration=60.0, rate=RATE, sensors=Sensors.ideal()), seed=3)
    sensors, rng = Sensors(), np.random.default_rng(4)
    blocks = []
    for minute in range(minutes):
        q, tau = sensors.angle(true.motion.q, rng), sensors.torque(true.torque, RATE, rng)
        t = np.arange(len(q)) / RATE + 60.0 * minute
        blocks.append(np.column_stack([t, sensors.logged(q), sensors.logged(tau, fewer=2)]))
    table = np.concatenate(blocks)
    names = ("t", "q1", "q2", "tau1", "tau2")
    for kind in formats:
        file = folder / f"hour.{kind}"
        if kind == "csv":
            with file.open("w") as stream:
                stream.write(",".join(names) + "\n")
                for block in blocks:
                    np.savetxt(stream, block, fmt="%.6f", delimiter=",")
        elif kind == "npz":
            np.savez(file, **dict(zip(names, table.T, strict=True)))
        elif kind == "mat":
            import scipy.io

            scipy.io.savemat(file, dict(zip(names, table.T, strict=True)))
        elif kind == "h5":
            import h5py

            with h5py.File(file, "w") as store:
                for name, column in zip(names, table.T, strict=True):
                    store[name] = column
        else:
            import pandas as pd

            pd.DataFrame(table, columns=names).to_parquet(file)


def write_hours(folder: Path, hours: float, formats: list[str]) -> None:
    """Write a recording of hours in each format, a minute at a time: the legs rest in the middle of every hour."""
    import pyarrow
    import pyarrow.csv
    import pyarrow.parquet

    from exoid.measurement.bench.sensors import Sensors
    from exoid.measurement.bench.simulation import Bench, run_bench
    from exoid.measurement.trajectories.trajectory import random_trajectory

    path = random_trajectory(np.random.default_rng(3), period=PERIOD)
    true = run_bench(excitation=path, bench=Bench(duration=60.0, rate=RATE, sensors=Sensors.ideal()), seed=3)
    rng = np.random.default_rng(4)
    clean = np.hstack([true.motion.q, true.torque])
    noise = np.array([2e-4, 2e-4, 0.3, 0.2])
    schema = pyarrow.schema([(name, "f8") for name in ("t", "q1", "q2", "tau1", "tau2")])
    opened = {
        kind: pyarrow.csv.CSVWriter(folder / f"hours.{kind}", schema)
        if kind == "csv"
        else pyarrow.parquet.ParquetWriter(folder / f"hours.{kind}", schema)
        for kind in formats
    }
    for minute in range(round(60 * hours)):
        rests = 25 <= minute % 60 < 35
        cells = (np.broadcast_to(clean[0], clean.shape) if rests else clean) + noise * rng.normal(size=clean.shape)
        t = np.arange(len(cells)) / RATE + 60.0 * minute
        table = pyarrow.Table.from_arrays([pyarrow.array(column) for column in (t, *cells.T)], schema=schema)
        for writer in opened.values():
            writer.write(table)
    for writer in opened.values():
        writer.close()


def peak() -> float:
    """Return the largest memory of this process so far in MB; where the system tells, without what its parent held."""
    try:
        text = Path("/proc/self/status").read_text()
        return int(text.partition("VmHWM:")[2].split()[0]) / 1024
    except (OSError, ValueError, IndexError):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def stage(name: str, path: Path) -> None:
    """Run the work up to the stage `name` and print the seconds it took, the peak memory in MB, and what came out.

    That of `compare` is all of it, from the file on.
    """
    from exoid.diagnosis.comparison import compare
    from exoid.measurement.reading.read import read_recording, read_recordings
    from exoid.optimisation.fitting.identify import identify
    from exoid.optimisation.preparation.prepare import prepare
    from exoid.symbolic.model import Model

    said = ""
    began = time.perf_counter()
    if name == "stretches":
        shares: list[float] = []
        runs = read_recordings([path], progress=lambda share, text: shares.append(share))
        first = next((one.what for one in runs[0].findings if one.check == "large"), "read as a whole")
        said = f"{first}; progress was told {len(shares)} times"
    elif name != "import":
        recording = read_recording(path)
        said = f"{len(recording)} rows, {[f.check for f in recording.findings]}"
    if name == "prepare":
        began = time.perf_counter()
        ready = prepare(Model.standard(), [recording])
        said = f"{sum(len(one.t) for one in ready.all)} samples, {ready.choice.reason}"
    if name == "compare":
        said = str(compare(Model.standard(), [recording])).splitlines()[0]
    if name == "identify":
        began = time.perf_counter()
        said = str(identify(Model.standard(), [recording])).splitlines()[0]
    took = time.perf_counter() - began
    busy = time.process_time()
    print(f"{name:>10} {took:8.1f} s (processor {busy:.0f} s) {peak():8.0f} MB   {said}", flush=True)


def command(arguments: list[str]) -> None:
    """Run one command as a user would, and print what it took."""
    began = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-m", "exoid.workbench.command", *arguments, "--quiet"], cwd=ROOT, stdout=subprocess.DEVNULL
    )
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    took = time.perf_counter() - began
    print(
        f"{arguments[0]:>10} {took:8.1f} s {usage.ru_maxrss / 1024:8.0f} MB   exit status {process.returncode}",
        flush=True,
    )


def main() -> None:
    """Make the recording, then run every stage on every format."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--minutes", type=int, default=60)
    parser.add_argument("--hours", type=float, help="so many hours, which are read piece by piece")
    parser.add_argument("--formats", nargs="+")
    parser.add_argument("--discover", action="store_true", help="also run exoid discover on the first format")
    parser.add_argument("--keep", type=Path, help="make the files in this folder and leave them there")
    parser.add_argument("--write", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--stage", nargs=2, help=argparse.SUPPRESS)
    args = parser.parse_args()
    args.formats = args.formats or (["csv", "parquet"] if args.hours else ["csv", "npz", "h5"])
    if args.stage:
        stage(args.stage[0], Path(args.stage[1]))
        return
    if args.write and args.hours:
        write_hours(args.write, args.hours, args.formats)
        return
    if args.write:
        write(args.write, args.minutes, args.formats)
        return
    with tempfile.TemporaryDirectory() as scratch:
        folder = args.keep or Path(scratch)
        files = [folder / f"{'hours' if args.hours else 'hour'}.{kind}" for kind in args.formats]
        if not all(file.exists() for file in files):
            # In a process of its own: what this one holds would be counted with every process it starts.
            given = ["--write", str(folder), "--minutes", str(args.minutes), "--formats", *args.formats]
            given += ["--hours", str(args.hours)] if args.hours else []
            subprocess.run([sys.executable, __file__, *given], check=True)
        for index, file in enumerate(files):
            print(f"{file.name}: {file.stat().st_size / 1e6:.0f} MB")
            for name in ("stretches",) if args.hours else STAGES if index == 0 else ("read", "compare"):
                subprocess.run([sys.executable, __file__, "--stage", name, str(file)], check=True)
        if args.discover:
            command(["discover", str(files[0])])


if __name__ == "__main__":
    main()
