"""Distances of the rivals from the certified optimum, their speed, and the differences that are more than chance."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from exoid.diagnosis.report.material import Material

TITLE = "Optimisers compared"
ORDER = 15


def context(material: Material) -> Mapping[str, Any] | None:
    """Return running times to every target and the tests, where optimisers were compared."""
    found = material.payload
    if not isinstance(found, Mapping) or found.get("schema") != "exoid.rivals/1":
        return None
    targets = [_power(item["target"]) for item in _shown(next(iter(found["optimisers"].values())))]
    return {
        "problem": found["problem"],
        "seeds": len(found["seeds"]),
        "budget": found["individuals"] * found["generations"],
        "reference": found["reference"],
        "ert_head": ("optimiser", "median gap", *targets),
        "ert_rows": [
            (name, optimiser["median_gap"], *(_time(runtime) for runtime in _shown(optimiser)))
            for name, optimiser in found["optimisers"].items()
        ],
        "test_head": ("optimiser", "question", "better", "worse", "p", "p (Holm)"),
        "test_rows": [
            (d["first"], d["question"], d["wins"], d["losses"], d["p"], d["p_holm"]) for d in found["differences"]
        ],
    }


def _shown(one: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return every second running time: all nine do not fit beside each other, and result.json has them."""
    return list(one["runtimes"][::2])


def _power(target: float) -> str:
    """Return 1e-10 as 10⁻¹⁰."""
    return "10" + str(round(math.log10(target))).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def _time(runtime: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a cell: expected evaluations, and how many runs came there where not all did."""
    hits, runs = runtime["hits"], runtime["runs"]
    if not hits:
        return {"value": 1e300, "text": "–"}
    few = "" if hits == runs else f" ({hits}/{runs})"
    return {"value": runtime["ert"], "text": f"{runtime['ert']:.0f}{few}"}
