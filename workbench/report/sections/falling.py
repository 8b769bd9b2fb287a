"""The falling error: one bar per step and joint, down to the noise floor."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from workbench.report.material import Material

TITLE = "The falling error"
ORDER = 20


def context(material: Material) -> Mapping[str, Any] | None:
    """Return the bars of each joint and the same numbers as a table."""
    if material.steps is None or not material.steps.rows:
        return None
    steps, kinds = material.steps, ("fitted", "unseen")
    return {
        "joints": [_bars(steps, index) for index in range(len(steps.joints))],
        "head": ("model", *(f"{joint}, {kind} [{steps.unit}]" for joint in steps.joints for kind in kinds)),
        "rows": [
            (
                row["model"],
                *(x for j in range(len(steps.joints)) for x in (row["train_rms"][j], _at(row["verify_rms"], j))),
            )
            for row in steps.rows
        ],
        "unseen": any(row["verify_rms"] is not None for row in steps.rows),
        "floor": steps.noise_floor is not None,
        "sentences": [(row["model"], row["sentence"]) for row in steps.rows if row.get("sentence")],
        "ending": steps.ending,
    }


def _bars(steps: Any, index: int) -> Mapping[str, Any]:
    """Return the bars of joint `index`, their lengths as per cent of the longest."""
    values = [x for row in steps.rows for x in (row["train_rms"][index], _at(row["verify_rms"], index))]
    longest = max((x for x in values if x is not None and math.isfinite(x)), default=0.0) or 1.0
    floor = _at(steps.noise_floor, index)
    rows = [
        {
            "model": row["model"],
            "train": row["train_rms"][index],
            "verify": _at(row["verify_rms"], index),
            "train_width": _width(row["train_rms"][index], longest),
            "verify_width": _width(_at(row["verify_rms"], index), longest),
        }
        for row in steps.rows
    ]
    return {"joint": steps.joints[index], "rows": rows, "floor": floor, "floor_width": _width(floor, longest)}


def _at(values: Any, index: int) -> float | None:
    return None if values is None else values[index]


def _width(value: float | None, longest: float) -> float:
    """Return a length in per cent; a value that is not finite fills the bar."""
    if value is None:
        return 0.0
    return round(100.0 * min(1.0, value / longest), 2) if math.isfinite(value) else 100.0
