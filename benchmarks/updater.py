"""What a step of the exported estimator costs in C, and how much longer it takes in Python.

    python benchmarks/updater.py

The C of `exoid export --updater` for the standard leg is compiled with -O2 and fed a minute of a simulated recording,
again and again; every call is timed by the clock of the machine. Nothing is asserted.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # must be set before NumPy is imported
ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402 - the repository must be on the path first

from benchmarks.python_updater import Updater  # noqa: E402
from exoid.apps.watch.front import CUTOFF  # noqa: E402
from exoid.apps.watch.updater import residual_scale, write_updater  # noqa: E402
from exoid.measurement.bench.leg import standard_leg  # noqa: E402
from exoid.measurement.bench.simulation import Bench, simulate  # noqa: E402
from exoid.symbolic.model import Model  # noqa: E402
from exoid.symbolic.model_file import Numbers  # noqa: E402

DRIVER = """#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <time.h>
#include "leg_updater.h"
int main(void) {
  static double rows[5 * %(count)d], spent[%(count)d];
  static leg_updater state;
  if (fread(rows, sizeof(double), 5 * %(count)d, stdin) != 5 * %(count)d) return 1;
  leg_updater_init(&state);
  for (int k = 0; k < %(count)d; ++k) {
    struct timespec begin, end;
    clock_gettime(CLOCK_MONOTONIC, &begin);
    leg_updater_step(&state, rows[5 * k], rows + 5 * k + 1, rows + 5 * k + 3);
    clock_gettime(CLOCK_MONOTONIC, &end);
    spent[k] = 1e9 * (double)(end.tv_sec - begin.tv_sec) + (double)(end.tv_nsec - begin.tv_nsec);
  }
  fwrite(spent, sizeof(double), %(count)d, stdout);
  return 0;
}
"""


def in_c(model: Model, numbers: Numbers, rows: np.ndarray, rate: float) -> np.ndarray:
    """Return the nanoseconds of every step."""
    compiler = next((c for c in ("cc", "gcc", "clang") if shutil.which(c)), None)
    if compiler is None:
        sys.exit("a C compiler is needed: cc, gcc or clang")
    with tempfile.TemporaryDirectory() as folder:
        for name, text in write_updater(model, numbers, name="leg", sample_time=1.0 / rate, cutoff=CUTOFF).items():
            Path(folder, name).write_text(text, "utf-8")
        Path(folder, "driver.c").write_text(DRIVER % {"count": len(rows)}, "utf-8")
        subprocess.run(
            [compiler, "-std=c99", "-O2", "driver.c", "leg_updater.c", "-o", "driver", "-lm"], cwd=folder, check=True
        )
        made = subprocess.run([f"{folder}/driver"], input=rows.tobytes(), capture_output=True, check=True)
    return np.frombuffer(made.stdout)


def main() -> None:
    """Print a line per rate."""
    model, leg = Model.standard(), standard_leg()
    numbers = Numbers(dict(zip((p.name for p in model.parameters), leg.base, strict=True)), {}, None)
    for rate in (100.0, 500.0, 1000.0):
        run = simulate(bench=Bench(duration=60.0, rate=rate), seed=3)
        rows = np.column_stack([np.arange(len(run)) / rate, run.q, run.tau])
        spent = in_c(model, numbers, rows, rate)
        python = Updater(model, np.array(leg.base), np.zeros(0), residual_scale(model, numbers), rate, CUTOFF)
        begin = time.perf_counter()
        python.push(rows)
        ratio = (time.perf_counter() - begin) / (1e-9 * float(spent.sum()))
        mean, most = 1e-3 * spent.mean(), 1e-3 * np.quantile(spent, 0.999)
        print(
            f"{rate:5.0f} Hz: {mean:.2f} µs a period, 99.9 % below {most:.1f} µs, {1e-4 * rate * mean:.2g} % of one "
            f"core; Python takes {ratio:.0f} times as long"
        )


if __name__ == "__main__":
    main()
