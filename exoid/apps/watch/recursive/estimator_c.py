"""The recursive estimator in C99 (`estimator_*.in`), for the controller (`exoid export --updater`) and for
`Estimator.steps`.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from exoid.ground.text import filled
from exoid.symbolic.codegen.cache import CompiledLibrary, GeneratedC, load_library
from exoid.symbolic.codegen.compiler import EXACT


@cache
def part_of_c(name: str) -> str:
    """Return a part of the C by its name: `fields.h`, what the estimator holds; `step.c`, `forget.c`, `spread.c`, what
    it does; `kernel.c`, all of it for many samples.
    """
    return Path(__file__).with_name(f"estimator_{name}.in").read_text("utf-8")


def layout(count: int, joints: int) -> np.dtype[Any]:
    """Return the fields as NumPy sees them, for `count` parameters."""
    p, j, square = (count,), (joints,), (count, count)
    shapes = {"linear": p, "variance": p, "root": square, "right": p, "credit": p, "score": p, "meat": square,
              "pace": p, "blocks": p, "feigned": square, "scale": j, "unit": j}  # fmt: skip
    return np.dtype([*((name, "f8", shape) for name, shape in shapes.items()), ("inside", np.intc)], align=True)


def kernel(values: Mapping[str, Any]) -> Any:
    """Return the compiled function for the constants `values`; None without a compiler."""
    parts = {"FIELDS": part_of_c("fields.h"), "ESTIMATION": part_of_c("step.c"), "TYPE": "exoid_estimator"}
    found = _loaded(filled(part_of_c("kernel.c"), parts | dict(values)))
    return None if found is None else found.c.exoid_estimate


@cache
def _loaded(text: str) -> CompiledLibrary | None:
    return load_library("estimator", text, EXACT, lambda: GeneratedC(text, EXACT, {}), ("exoid_estimate",))
