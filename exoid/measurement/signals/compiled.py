"""Functions of `rows.c` on rows of samples where there is a compiler: filtering both ways, bridging, banded equations.

Matrix products do the same without one; `discover` then takes 1.3 to 1.45 times the processor time on four runs of a
leg (4.3 instead of 3.3 s, 6.7 instead of 5.0, 11.3 instead of 8.0).
"""

from __future__ import annotations

from ctypes import Structure, c_long, c_void_p
from functools import lru_cache
from pathlib import Path

import numpy as np

from exoid.symbolic.codegen.cache import CompiledLibrary, GeneratedC, load_library
from exoid.symbolic.codegen.compiler import FAST
from exoid.symbolic.motion import Float

POLES = 2
"""Pairs of poles of the filter that everything goes through."""

FEWEST = 2
"""Rows from which on filtering in C is worth its call; fewer are filtered by products."""


FUNCTIONS = ("exoid_both_ways_at", "exoid_bridge", "exoid_pentadiagonal", "exoid_wave_products")
"""What is called in `rows.c`."""


class BridgeInC(Structure):
    """A `Bridge` as C reads it; whoever makes one keeps its arrays."""

    _fields_ = (
        ("hidden", c_long), ("means", c_long), ("at", c_void_p), ("ends", c_void_p), ("begins", c_void_p),
        ("beside", c_void_p), ("share", c_void_p),
    )  # fmt: skip


@lru_cache
def row_library(poles: int) -> CompiledLibrary | None:
    """Return `exoid_both_ways_at` for filters of so many poles, and the other functions; None without a compiler."""
    text = f"#define POLES {poles}\n{Path(__file__).with_name('rows.c').read_text('utf-8')}"
    return load_library("rows", text, FAST, lambda: GeneratedC(text, FAST, {}), FUNCTIONS)


def solved_banded(bands: Float, right: Float) -> Float:
    """Return x (N,) of A x = `right` (N,), A symmetric and positive definite with `bands` (3, N): the second diagonal
    from place 2 on, the first from place 1 on, its own. SciPy does it without a compiler: 187 µs instead of 41 for
    3000 samples, after an import of 0.15 s, a tenth of `discover` on the demo's recordings.
    """
    library = row_library(POLES)
    if library is None:
        from scipy.linalg import solveh_banded

        return np.asarray(solveh_banded(bands, right))
    second, first, own = (np.append(band[k:], np.zeros(k)) for k, band in zip((2, 1, 0), bands, strict=True))
    x = np.array(right, dtype=float)
    library.c.exoid_pentadiagonal(c_long(x.size), *(c_void_p(each.ctypes.data) for each in (own, first, second, x)))
    return x
