"""Sum of squares and Huber loss of many candidates at once, compiled for the regressor's pattern of zeros.

For the residual r = τ - YΦ and c = min(|r|, δ) the Huber term is c (2|r| - c), free of branches. CasADi
writes the terms of one sample and four candidates as scalar C over the non-zero entries only (10 of 16 for
the plain leg); a small loop over contiguous arrays inlines it, and the compiler vectorises over the
samples. The data lie chunk after chunk, so that a long recording is read from memory in one straight line.
"""

from __future__ import annotations

import ctypes
import itertools
import threading
from dataclasses import dataclass
from typing import Any

import numpy as np

from exoid.ground.text import filled
from exoid.symbolic.codegen.cache import CompiledLibrary, GeneratedC, load_library
from exoid.symbolic.codegen.compiler import FAST
from exoid.symbolic.codegen.instructions import scalar_c, template
from exoid.symbolic.motion import Float

LANES = 4
"""Candidates per pass: each entry is loaded once for all of them. More lanes spill registers."""

CHUNK = 512
"""Samples per pass: entries and torque of one chunk (12 x 4 kB) stay in the nearest caches for all candidates."""

STRETCH = 64
"""Chunks whose loss is summed on its own: what threads share, and short sums round less."""

EVEN = 8
"""Stretches per thread from which threads share them: fewer cannot be shared evenly, and caches hold them for all."""

Entries = tuple[tuple[int, int], ...]


@dataclass(frozen=True, eq=False)
class Fitness:
    """The loss of populations for fixed data of N `samples`.

    `chunks` (C, K + J, CHUNK) holds the non-zero entries, then the torques; after the last sample it is zero.
    """

    entries: Entries
    size: int
    joints: int
    samples: int
    chunks: Float
    library: CompiledLibrary | None

    @property
    def backend(self) -> str:
        """Return "c" or "numpy"."""
        return "numpy" if self.library is None else "c"

    def sse(self, population: Any, threads: int = 1) -> Float:
        """Return the sum of squared residuals (I,) over samples and joints for `population` (I, P).

        `threads` share the samples of a long recording, the candidates otherwise; the result is the same to the last
        bit for any number of them.
        """
        return self._evaluate(population, None, threads)

    def huber(self, population: Any, delta: Any, threads: int = 1) -> Float:
        """Return the Huber loss (I,) of `population` (I, P) with thresholds `delta` (J,) in N·m; threads as in sse."""
        threshold = np.ascontiguousarray(delta, dtype=float)
        if threshold.shape != (self.joints,) or not np.all(threshold > 0.0):
            raise ValueError(f"delta is {delta!r}; it must hold a positive threshold for each of {self.joints} joints")
        return self._evaluate(population, threshold, threads)

    def _evaluate(self, population: Any, delta: Float | None, threads: int) -> Float:
        if threads < 1:
            raise ValueError(f"threads is {threads}; at least one has to do the work")
        candidates = np.ascontiguousarray(np.atleast_2d(population), dtype=float)
        if candidates.ndim != 2 or candidates.shape[1] != self.size:
            raise ValueError(f"population has shape {candidates.shape}, expected (I, {self.size})")
        out = np.zeros(len(candidates))
        # -ffast-math assumes finite numbers: candidates that are not get their NaN here.
        finite = np.isfinite(candidates).all(axis=1)
        if not finite.all():
            out[~finite] = np.nan
            out[finite] = self._evaluate(candidates[finite], delta, threads) if finite.any() else out[finite]
            return out
        if self.library is None:
            return self._in_numpy(candidates, delta)
        # A threshold of infinity is beyond any finite residual, but not beyond -ffast-math.
        bounded = None if delta is None else np.minimum(delta, np.finfo(float).max / 4)
        return self._in_c(self.library.c, candidates, bounded, threads)

    def _in_c(self, library: ctypes.CDLL, candidates: Float, delta: Float | None, threads: int) -> Float:
        """Sum each stretch apart and then the stretches in order, however many threads there are."""
        count = -(-len(self.chunks) // STRETCH)
        parts = np.zeros((count, len(candidates)))
        if EVEN * threads <= count:
            borders = [count * k // threads for k in range(threads + 1)]
            tasks = [(part, slice(None)) for part in _runs(borders)]
        else:  # whole passes of LANES, so that every candidate meets the same instructions
            passes = -(-len(candidates) // LANES)
            borders = [min(passes * k // threads * LANES, len(candidates)) for k in range(threads + 1)]
            tasks = [(slice(0, count), part) for part in _runs(borders)]

        def work(task: tuple[slice, slice]) -> None:
            mine = np.ascontiguousarray(candidates[task[1]])
            for stretch in range(task[0].start, task[0].stop):
                data = self.chunks[stretch * STRETCH : (stretch + 1) * STRETCH]
                samples = min(self.samples - stretch * STRETCH * CHUNK, STRETCH * CHUNK)
                _call(library, samples, data, mine, delta, parts[stretch, task[1]])

        others = [threading.Thread(target=work, args=(task,)) for task in tasks[1:]]
        for other in others:
            other.start()
        work(tasks[0])
        for other in others:
            other.join()
        total = np.zeros(len(candidates))
        for part in parts:
            total += part
        return total

    def _in_numpy(self, candidates: Float, delta: Float | None) -> Float:
        """Do the same in NumPy, a chunk of samples at a time."""
        out = np.zeros(len(candidates))
        count = len(self.entries)
        for block in self.chunks:
            for joint in range(self.joints):
                chosen = [k for k, (j, _) in enumerate(self.entries) if j == joint]
                used = [self.entries[k][1] for k in chosen]
                residual = candidates[:, used] @ block[chosen]
                np.subtract(block[count + joint], residual, out=residual)
                if delta is None:
                    out += np.einsum("in,in->i", residual, residual)
                else:
                    np.abs(residual, out=residual)
                    clipped = np.minimum(residual, delta[joint])
                    out += np.einsum("in,in->i", clipped, 2.0 * residual - clipped)
        return out


def fitness(columns: Any, tau: Any) -> Fitness:
    """Return the fitness of columns (J, N, P) and measured torque `tau` (J, N) in N·m.

    ValueError where the shapes do not match or a value is not finite.
    """
    regressor, torque = np.asarray(columns, dtype=float), np.asarray(tau, dtype=float)
    if regressor.ndim != 3 or torque.shape != regressor.shape[:2]:
        raise ValueError(f"columns have shape {regressor.shape}, tau has {torque.shape}; expected (J, N, P) and (J, N)")
    if not (np.isfinite(regressor).all() and np.isfinite(torque).all()):
        raise ValueError("columns or tau hold values that are not finite; leave those rows out")
    joints, _, size = regressor.shape
    entries = tuple((j, p) for j in range(joints) for p in range(size) if np.any(regressor[j, :, p]))
    rows = [regressor[j, :, p] for j, p in entries] + [*torque]
    samples = regressor.shape[1]
    whole = samples // CHUNK
    chunks = np.zeros((-(-samples // CHUNK), len(rows), CHUNK))
    for k, row in enumerate(rows):
        chunks[:whole, k] = row[: whole * CHUNK].reshape(whole, CHUNK)
        chunks[whole:, k, : samples - whole * CHUNK] = row[whole * CHUNK :]
    return Fitness(entries, size, joints, samples, chunks, kernel_for(entries, size, joints))


_LOADED: dict[Any, CompiledLibrary] = {}


def kernel_for(entries: Entries, size: int, joints: int) -> CompiledLibrary | None:
    """Return the compiled kernel for a pattern of non-zero `entries` (joint, parameter); None without a
    compiler.
    """
    content = [[list(entry) for entry in entries], size, joints, LANES, CHUNK]
    key = repr(content)
    if key not in _LOADED:
        source = lambda: GeneratedC(kernel_source(entries, size, joints), FAST, {})  # noqa: E731
        found = load_library("fitness", content, FAST, source, ("exoid_fitness",))
        if found is None:
            return None
        _LOADED[key] = found
    return _LOADED[key]


def _runs(borders: list[int]) -> list[slice]:
    """Return the stretches between `borders` that are not empty; one empty where all are."""
    runs = [slice(a, b) for a, b in itertools.pairwise(borders) if b > a]
    return runs or [slice(0, 0)]


def _call(
    library: ctypes.CDLL, samples: int, chunks: Float, candidates: Float, delta: Float | None, out: Float
) -> None:
    """Add losses to `out`; ctypes lets go of the interpreter meanwhile, so that threads work side by side."""
    pointer = ctypes.POINTER(ctypes.c_double)

    def at(array: Float | None) -> Any:
        return None if array is None else array.ctypes.data_as(pointer)

    library.exoid_fitness(
        ctypes.c_long(samples), at(chunks), ctypes.c_long(len(candidates)), at(candidates), at(delta), at(out)
    )


def kernel_source(entries: Entries, size: int, joints: int) -> str:
    """Return the C text of the kernel for one pattern of zeros."""
    passes = []
    for name in ("sse", "huber"):
        inputs, lanes = range(len(entries) + joints), range(LANES)
        passes.append(filled(template("fitness_pass.c.in"), {
            "NAME": name,
            "LOADS": "\n".join(f"    const double y{k} = data[{k} * {CHUNK} + n];" for k in inputs),
            "NUMBERS": "\n".join(f"  const double p{k} = phi[{k}];" for k in range(size * LANES)),
            "THRESHOLDS": "\n".join(f"  const double d{j} = delta ? delta[{j}] : 0;" for j in range(joints)),
            "SUMS": ", ".join(f"s{k} = 0" for k in lanes), "REDUCTION": ",".join(f"s{k}" for k in lanes),
            "BODY": _terms(name, entries, size, joints), "ADD": "\n".join(f"  out[{k}] += s{k};" for k in lanes),
        }))  # fmt: skip
    sizes = {"SIZE": size, "LANES": LANES, "CHUNK": CHUNK, "ROWS": len(entries) + joints}
    return filled(template("fitness.c.in"), {"PASSES": "\n".join(passes), **sizes})


def _terms(name: str, entries: Entries, size: int, joints: int) -> str:
    """Return the loss of one sample for all lanes as statements on the scalars y, p, d and s."""
    import casadi

    y = casadi.SX.sym("y", len(entries) + joints)
    phi = casadi.SX.sym("phi", size * LANES)
    delta = casadi.SX.sym("delta", joints)
    losses = []
    for lane in range(LANES):
        loss = casadi.SX(0)
        for joint in range(joints):
            residual = y[len(entries) + joint]
            for k, (j, p) in enumerate(entries):
                if j == joint:
                    residual = residual - y[k] * phi[lane * size + p]
            if name == "sse":
                loss += residual * residual
            else:
                size_of = casadi.fabs(residual)
                clipped = casadi.fmin(size_of, delta[joint])
                loss += clipped * (2 * size_of - clipped)
        losses.append(loss)
    function = casadi.Function(name, [y, phi, delta], [casadi.vertcat(*losses)], {"cse": True})
    counts = {"y": y.numel(), "p": phi.numel(), "d": joints}
    inputs = [[f"{letter}{k}" for k in range(count)] for letter, count in counts.items()]
    return scalar_c(function, inputs, "s{k} += {value};")
