"""Cells of tables, and effects in words: what several sections of a report say alike."""

from __future__ import annotations

import math
from typing import Any

from exoid.symbolic.effect import Effect
from exoid.symbolic.effect_catalogue import every_effect


def share(value: float | None, form: str = ".0f") -> dict[str, Any] | None:
    """Return a share as per cent in a `form`, sorted by its number; None where there is none."""
    if value is None or not math.isfinite(value):
        return None
    return {"value": float(value), "text": f"{100 * float(value):{form}} %"}


def error_sizes(found: Any) -> tuple[list[str], list[tuple[Any, ...]]]:
    """Return the head and the rows of a table with the size of the error of each joint beside that of its torque."""
    columns = {
        "torque": found.signal_rms,
        "error, fitted": found.rms,
        "error, unseen": (None,) * len(found.joints) if found.verify_rms is None else found.verify_rms,
        "noise floor": found.noise_floor,
    }
    rows = zip(found.joints, *columns.values(), strict=True)
    head = ["joint", *(f"{word} [{found.unit}]" for word in columns)]
    return head, [(joint, *(None if x is None else float(x) for x in values)) for joint, *values in rows]


def effect_of(name: str, model: Any) -> Effect | None:
    """Return the effect of "stribeck:knee", one of the user's own in `model` first; None for an unknown name."""
    id = name.partition(":")[0]
    own = [*getattr(model, "custom", ()), *(getattr(t, "effect", None) for t in getattr(model, "terms", ()))]
    found = next((item for item in own if isinstance(item, Effect) and item.id == id), None)
    return found or every_effect().get(id)


def said_of(name: str, model: Any) -> str:
    """Sentence of the catalogue for a technician; "" for an unknown name."""
    effect = effect_of(name, model)
    return "" if effect is None else effect.explains
