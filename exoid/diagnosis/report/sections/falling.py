"""The falling error: one bar per step and joint, down to the noise floor."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from exoid.diagnosis.report.material import Context, Material
from exoid.diagnosis.report.sections.verdict import title
from exoid.symbolic.wording import added_said

TITLE = "The falling error"
ORDER = 20


def context(material: Material) -> Context:
    """Return the bars of each joint and the same numbers as a table."""
    fall, kinds = material.fall, ("fitted", "unseen")
    if fall is None:
        return None
    none = [None] * len(fall.joints)
    words = [added_said(step.label, partial(title, model=material.model)) for step in fall.steps]
    sizes = [
        [*zip(map(float, step.train_rms), none if step.verify_rms is None else step.verify_rms, strict=True)]
        for step in fall.steps
    ]
    return {
        "joints": [_bars(fall, j, words, [own[j] for own in sizes]) for j in range(len(fall.joints))],
        "head": ("model", *(f"{joint}, {kind} [{fall.unit}]" for joint in fall.joints for kind in kinds)),
        "rows": [(word, *(x for pair in own for x in pair)) for word, own in zip(words, sizes, strict=True)],
        "unseen": any(step.verify_rms is not None for step in fall.steps),
        "sentences": [(step.label, step.sentence) for step in fall.steps if step.sentence],
        "ending": fall.stopped_because if material.diagnosis is not None else "",  # of models given nothing stopped
        "unit": fall.unit,
    }


def _bars(fall: Any, j: int, words: Sequence[str], sizes: Sequence[tuple[float, float | None]]) -> Mapping[str, Any]:
    """Return the bars of joint `j`, whose errors are `sizes`, their lengths as per cent of the longest."""
    longest = max((x for pair in sizes for x in pair if x is not None and math.isfinite(x)), default=0.0) or 1.0
    rows = [
        {
            "model": word, "train": train, "train_width": _width(train, longest),
            "verify": verify, "verify_width": _width(verify, longest),
        }
        for word, (train, verify) in zip(words, sizes, strict=True)
    ]  # fmt: skip
    return {"joint": fall.joints[j], "rows": rows, "floor_width": _width(float(fall.noise_floor[j]), longest)}


def _width(value: float | None, longest: float) -> float:
    """Return a length in per cent; a value that is not finite fills the bar."""
    if value is None:
        return 0.0
    return round(100.0 * min(1.0, value / longest), 2) if math.isfinite(value) else 100.0
