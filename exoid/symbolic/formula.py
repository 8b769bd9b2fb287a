"""A torque text as a person would write it by hand, without loading any mathematics."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from exoid.symbolic.effect import Effect

DIGITS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
POWERS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


def pretty(text: str) -> str:
    """Return "c·θ′·|θ′|" for "c * dtheta * abs(dtheta)"."""
    text = text.replace("ddtheta", "θ″").replace("dtheta", "θ′").replace("theta", "θ").replace("tau_", "τ_")
    text = re.sub(r"(θ[′″]?|τ_rigid|τ_model)([12])\b", lambda m: m[1] + m[2].translate(DIGITS), text)
    text = re.sub(r"\babs\(([^()]*)\)", r"|\1|", text)
    text = re.sub(r"\s*(?:\*\*|\^)\s*(-?\d)(?![\d.])", lambda m: m[1].translate(POWERS), text)
    text = re.sub(r"\s*\*\*\s*", "^", text)
    return re.sub(r"\s*\*\s*", "·", text).strip()


def formula(effect: Effect) -> dict[str, str]:
    """Return the torque of `effect` per joint: {"": text} for its own joint, or {"hip": ..., "knee": ...}."""
    if effect.torque is None:
        return {"": pretty(effect.made_by) if effect.deflection else effect.made_by}
    if isinstance(effect.torque, str):
        return {"": pretty(effect.torque)}
    return {joint: pretty(text) for joint, text in effect.torque.items()}
