"""Description of an effect in a report: its name in words, its torque, what it means and what distinguishes it."""

from __future__ import annotations

from typing import Any

from exoid.symbolic.effect import Effect
from exoid.symbolic.effect_catalogue import every_effect
from exoid.symbolic.formula import formula


def effect_of(name: str, model: Any = None) -> Effect | None:
    """Return the effect of "stribeck:knee", one of the user's own in `model` first; None for an unknown name."""
    id = name.partition(":")[0]
    own = [*getattr(model, "custom", ()), *(getattr(t, "effect", None) for t in getattr(model, "terms", ()))]
    found = next((item for item in own if isinstance(item, Effect) and item.id == id), None)
    return found or every_effect().get(id)


def said_of(name: str, model: Any = None, what: str = "explains") -> str:
    """Return the sentence of the catalogue for a technician, or of "tells_apart" the look-alikes and the experiment
    that distinguishes them; "" for an unknown name.
    """
    return str(getattr(effect_of(name, model), what, ""))


def torque(name: str, model: Any = None) -> str:
    """Return the torque the effect adds, as a person would write it, or ""."""
    effect = effect_of(name, model)
    if effect is None:
        return ""
    return "; ".join(f"{joint}: {text}" if joint else text for joint, text in formula(effect).items())
