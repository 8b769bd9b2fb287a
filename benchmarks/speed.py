"""How long things take, as ratios in one run (`python benchmarks/speed.py`); nothing is asserted."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))


def seconds(function, repeats: int = 5) -> float:
    best = float("inf")
    for _ in range(repeats):
        began = time.perf_counter()
        function()
        best = min(best, time.perf_counter() - began)
    return best


def process(code: str):
    return lambda: subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True, capture_output=True)


def main() -> None:
    from exoid.diagnosis.discovery import discover
    from exoid.measurement.bench.simulation import Bench, run_bench
    from exoid.measurement.reading.read import read_recording
    from exoid.symbolic.model import Model

    bare = seconds(process("pass"))
    helped = seconds(process("from exoid.workbench.command import main; main(['--help'])"))
    bench = seconds(lambda: run_bench(seed=2, bench=Bench(duration=20.0)), 3)
    data = ROOT / "exoid" / "workbench" / "demo_data"
    train = [read_recording(data / f"train_{k}.csv") for k in (1, 2, 3)]
    verify = [read_recording(data / "verify.csv")]
    found = seconds(lambda: discover(Model.standard(), train, verify), 2)
    motion = sum(r.duration for r in (*train, *verify))
    lines = (
        f"exoid --help against a bare interpreter    {helped / bare:6.1f} times ({helped:.2f} s)",
        f"virtual bench against real time            {20.0 / bench:6.0f} times faster",
        f"discover on the demo against its recording {motion / found:6.1f} times faster ({found:.1f} s)",
    )
    sys.stdout.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
