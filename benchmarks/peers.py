"""The same work by others, in one run: `python benchmarks/peers.py [RUN.csv ...]`, on the demo without files.

Needs `.[peers]`. Each line is CPU time of one thread against ours for the same numbers or a part of them, on recordings
that are read and prepared: weighted least squares as FIGAROH and most papers do it, Huber's loss by SciPy, PySINDy's
sparse regression, SciPy's filter. The last is what no reader can get below: the bytes of the files, read once.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402 - the number of threads must be set first


def seconds(function: Callable[[], object], repeats: int = 9) -> float:
    """Return the least CPU time in s of several runs, after one that is not counted."""
    function()
    times = []
    for _ in range(repeats):
        began = time.process_time()
        function()
        times.append(time.process_time() - began)
    return min(times)


def main(files: list[Path]) -> None:
    """Measure and print."""
    from pysindy import STLSQ
    from scipy.optimize import least_squares
    from scipy.signal import butter, sosfiltfilt

    from exoid.measurement.reading.read import read_recording
    from exoid.measurement.signals.conditioning import low_pass
    from exoid.optimisation.fitting.assemble import assemble
    from exoid.optimisation.fitting.identify import identify
    from exoid.optimisation.linear.solve import delta_rule, solve_huber, solve_sse
    from exoid.optimisation.preparation.prepare import prepare
    from exoid.symbolic.model import Model

    model = Model.standard()
    recordings = [read_recording(file) for file in files]
    prepared = prepare(model, recordings, cutoff=5.0).train
    data = assemble(model, prepared)
    linear = solve_sse(data)
    delta = delta_rule(data.residual(linear), use=data.use)
    limit = np.repeat(delta, data.tau.shape[1])
    columns, torque = np.array(data.matrix), np.array(data.vector)

    def weighted() -> np.ndarray:
        first = np.linalg.lstsq(columns, torque, rcond=None)[0]
        weight = np.repeat(1.0 / data.rms(first), data.tau.shape[1])
        found = np.linalg.lstsq(columns * weight[:, None], torque * weight, rcond=None)[0]
        np.linalg.inv((columns * weight[:, None]).T @ (columns * weight[:, None]))
        return np.asarray(found)

    def huber() -> np.ndarray:
        scaled = columns / limit[:, None], torque / limit
        return np.asarray(
            least_squares(
                lambda x: scaled[0] @ x - scaled[1], linear, jac=lambda x: scaled[0], loss="huber", method="trf"
            ).x
        )

    q = np.concatenate([recording.q for recording in recordings])
    rate = 1.0 / float(np.median(np.diff(recordings[0].t)))
    sections = butter(4, 5.0, fs=rate, output="sos")

    def parsed() -> list[np.ndarray]:
        return [np.loadtxt(file, delimiter=",", skiprows=1) for file in files]

    def counted() -> int:
        return sum(int(np.frombuffer(file.read_bytes(), np.uint8).sum()) for file in files)

    reading = seconds(lambda: [read_recording(file) for file in files], 3)
    fresh = [lambda: assemble(model, prepared).factor, lambda: solve_huber(assemble(model, prepared), delta)]
    bare = seconds(lambda: assemble(model, prepared))
    rows = (
        ("least squares, two passes, weighted, with covariance", "NumPy", seconds(weighted), "columns to numbers",
         seconds(fresh[0]) - bare),
        ("Huber's loss to its minimum", "SciPy least_squares", seconds(huber), "solve_huber", seconds(fresh[1]) - bare),
        ("sparse regression, one threshold", "PySINDy STLSQ",
         seconds(lambda: STLSQ(threshold=0.1, alpha=1e-6).fit(columns, torque[:, None])), "solve_huber",
         seconds(fresh[1]) - bare),
        ("zero-phase low-pass of two angles", "SciPy sosfiltfilt", seconds(lambda: sosfiltfilt(sections, q, axis=0)),
         "low_pass", seconds(lambda: low_pass(q, 5.0, rate))),
        ("weighted least squares against a whole fit", "NumPy", seconds(weighted), "identify, light: columns, SSE, "
         "Huber, certificate, intervals", seconds(lambda: identify(model, prepared, optimisers=()))),
        ("the files as numbers", "numpy.loadtxt", seconds(parsed, 3), "read_recording, audited", reading),
        ("the bytes of the files once", "NumPy", seconds(counted), "read_recording, audited", reading),
    )  # fmt: skip
    for what, peer, theirs, own, ours in rows:
        print(f"{what}: {peer} {1e3 * theirs:.2f} ms; {own} {1e3 * ours:.2f} ms; {theirs / ours:.2g} times ours")


if __name__ == "__main__":
    given = [Path(name) for name in sys.argv[1:]]
    main(given or [ROOT / "exoid" / "workbench" / "demo_data" / f"train_{k}.csv" for k in (1, 2, 3)])
