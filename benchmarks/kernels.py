"""The generated code against its rivals, as ratios in one run (`python benchmarks/kernels.py [--large]`).

Huber population kernel (40 candidates, the plain leg's ten non-zero entries): our C, on one and two threads, against
NumPy in place and CasADi's virtual machine; its cost per sample as the recording grows (--large: to 10 million
samples, 1 GB); cold derive-generate-compile and warm start. Nothing is asserted.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # NumPy on one core, as the kernel beside it
ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402 - the number of threads must be set first

CANDIDATES = 40
DELTA = np.array([138.46, 92.89])
"""Thresholds of the paper, N·m."""


def seconds(function, repeats: int) -> float:
    best = float("inf")
    for _ in range(repeats):
        began = time.perf_counter()
        function()
        best = min(best, time.perf_counter() - began)
    return best


def problem(samples: int):
    from exoid.symbolic.codegen.fitness import fitness
    from exoid.symbolic.codegen.kernel import compiled
    from exoid.symbolic.model import Model
    from exoid.symbolic.motion import Motion

    rng = np.random.default_rng(1)
    motion = Motion(np.arange(samples) * 0.01, *(rng.normal(size=(samples, 2)) for _ in range(3)))
    columns = compiled(Model.standard()).columns(motion)
    return fitness(columns, rng.normal(scale=100.0, size=(2, samples))), rng.normal(scale=20.0, size=(CANDIDATES, 8))


def lines(made):
    """Entries and torques (K + J, N), each in one line."""
    return np.swapaxes(made.chunks, 0, 1).reshape(made.chunks.shape[1], -1)[:, : made.samples]


def in_place(made, population):
    """The best NumPy known: entries that are zero left out, a joint's population at once, no new arrays."""
    count, whole = len(made.entries), lines(made)
    size, clipped = (np.empty((len(population), made.samples)) for _ in range(2))
    parts = []
    for joint in range(2):
        chosen = [k for k, (j, _) in enumerate(made.entries) if j == joint]
        numbers = np.ascontiguousarray(population[:, [made.entries[k][1] for k in chosen]])
        parts.append((numbers, np.ascontiguousarray(whole[chosen]), whole[count + joint], DELTA[joint]))

    def run():
        total = np.zeros(len(population))
        for numbers, rows, tau, delta in parts:
            np.matmul(numbers, rows, out=size)
            np.subtract(tau, size, out=size)
            np.abs(size, out=size)
            np.minimum(size, delta, out=clipped)
            np.multiply(size, 2.0, out=size)
            np.subtract(size, clipped, out=size)
            total += np.einsum("in,in->i", clipped, size)
        return total

    return run


def machine(made, population):
    """The same sum over whole columns as one CasADi function of the parameters, in the virtual machine."""
    import casadi

    count = len(made.entries)
    data, phi = casadi.MX.sym("data", made.samples, count + 2), casadi.MX.sym("phi", 8)
    columns = casadi.horzsplit(data)
    loss = casadi.MX(0)
    for joint in range(2):
        rest = columns[count + joint]
        for k, (j, p) in enumerate(made.entries):
            if j == joint:
                rest = rest - columns[k] * phi[p]
        size = casadi.fabs(rest)
        clipped = casadi.fmin(size, DELTA[joint])
        loss += casadi.dot(clipped, 2 * size - clipped)
    function = casadi.Function("loss", [data, phi], [loss])
    rows = casadi.DM(lines(made).T)
    return lambda: np.array([float(function(rows, one)) for one in population[:4]])


def peers() -> list[str]:
    made, population = problem(3_500)
    ours, numpy, vm = (lambda: made.huber(population, DELTA)), in_place(made, population), machine(made, population)
    if not np.allclose(ours(), numpy(), rtol=1e-11) or not np.allclose(ours()[:4], vm(), rtol=1e-11):
        raise SystemExit("the peers do not compute the same numbers; no ratio would mean anything")
    # Taken in turns, so that a busy moment of the machine meets all of them.
    times = np.array([[seconds(f, 20) for f in (ours, numpy, lambda: made.sse(population, 1))] for _ in range(15)])
    c, np_time, sse = times.min(axis=0) / CANDIDATES
    vm_time = seconds(vm, 3) / 4
    return [
        f"backend {made.backend}; per candidate, 3 500 samples x 2 joints, one thread",
        f"Huber in C           {c * 1e6:8.2f} µs",
        f"SSE in C             {sse * 1e6:8.2f} µs  {sse / c:6.2f} of Huber",
        f"NumPy in place       {np_time * 1e6:8.2f} µs  {np_time / c:6.1f} times ours",
        f"CasADi VM            {vm_time * 1e6:8.2f} µs  {vm_time / c:6.1f} times ours",
    ]


def growth(sizes: tuple[int, ...]) -> list[str]:
    lines = ["", "     samples   µs per candidate and 3 500 samples   two threads   same bits"]
    for samples in sizes:
        made, population = problem(samples)
        repeats = max(5, 200_000 // samples)
        one = seconds(lambda m=made, p=population: m.huber(p, DELTA, threads=1), repeats)
        two = seconds(lambda m=made, p=population: m.huber(p, DELTA, threads=2), repeats)
        same = np.array_equal(made.huber(population, DELTA, threads=1), made.huber(population, DELTA, threads=2))
        each = one / CANDIDATES / samples * 3_500 * 1e6
        lines.append(f"{samples:12,d}   {each:32.2f}   {one / two:8.2f} x   {'yes' if same else 'NO'}")
    return lines


START = """
import time
import numpy
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Motion
model = Model.standard(){effects}
began = time.perf_counter()
from exoid.symbolic.codegen.fitness import fitness
from exoid.symbolic.codegen.kernel import compiled
made = compiled(model)
motion = Motion(numpy.arange(9) * 0.01, *(numpy.random.default_rng(k).normal(size=(9, 2)) for k in range(3)))
loss = fitness(made.columns(motion), numpy.ones((2, 9))).sse(numpy.ones((1, len(model.parameters))))
print(time.perf_counter() - began)
"""
RICH = '.with_effect("stribeck", "knee").with_effect("hysteresis", "hip").with_effect("com_offset_shank")'


def starts() -> list[str]:
    """Model to first loss, in a new process with an empty and then a filled cache; process start apart."""
    lines = ["", "model to first loss (model functions and fitness kernel)   cold      warm    whole warm process"]
    for name, effects in (("the standard leg", ""), ("with three effects, one with memory", RICH)):
        with tempfile.TemporaryDirectory() as folder:
            environment = {**os.environ, "EXOID_CACHE": folder}
            spent, whole = [], []
            for _ in range(4):
                began = time.perf_counter()
                command = [sys.executable, "-c", START.format(effects=effects)]
                done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=True)
                whole.append(time.perf_counter() - began)
                spent.append(float(done.stdout))
        lines.append(f"{name:52s} {spent[0]:9.2f} s {min(spent[1:]):7.3f} s {min(whole[1:]):9.2f} s")
    return lines


def main() -> None:
    sizes = (3_500, 35_000, 350_000) + ((3_500_000, 10_000_000) if "--large" in sys.argv[1:] else ())
    for part in (peers, starts, lambda: growth(sizes)):
        sys.stdout.write("\n".join(part()) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
