"""Closed forms that come close to a learnt curve, in the torque language, to be pasted into a model."""

from __future__ import annotations

from typing import Any

import numpy as np

from diagnosis.evidence.curves import split_variable, variables
from diagnosis.evidence.remainder import Remainder, Suggestion
from symbolic.joints import UNITS
from symbolic.motion import Float


def suggest(one: Remainder) -> tuple[Suggestion, ...]:
    """Return closed forms for a learnt curve, best first: a bump, a step, a wave, powers."""
    from scipy.optimize import least_squares

    word = _word(one)
    x, y = one.x, one.y - one.y.mean()
    unit, torque = variables(one.joints)[one.variable][1], UNITS["tau"][not one.joints[one.index].turns]
    span, middle = float(np.ptp(x)), float(x.mean())
    peak = float(x[np.argmax(np.abs(y))])
    factor = {"sign": " * sgn(dtheta)", "speed": " * dtheta"}.get(one.factor, "")
    forms = (
        (f"c * exp(-(({word} - m)/w)**2){factor}", lambda p: np.exp(-(((x - p[0]) / p[1]) ** 2)), (peak, 0.15 * span)),
        (f"c * tanh(({word} - m)/w){factor}", lambda p: np.tanh((x - p[0]) / p[1]), (middle, 0.2 * span)),
        (f"c * ({word} - m)**2{factor}", lambda p: (x - p[0]) ** 2 + 0.0 * p[1], (middle, 1.0)),
        (f"c * ({word} - m)**3{factor}", lambda p: (x - p[0]) ** 3 + 0.0 * p[1], (middle, 1.0)),
    )
    out = []
    total = float(np.sum(y**2)) or 1.0
    for text, shape, start in forms:
        low = [x.min() - 0.2 * span, 0.02 * span if "/w" in text else 0.5]
        high = [x.max() + 0.2 * span, 1.5 * span if "/w" in text else 2.0]

        def misfit(p: Float, shape: Any = shape) -> Float:
            g = shape(p) - shape(p).mean()
            c = float(g @ y) / max(float(g @ g), 1e-300)
            return y - c * g

        found = least_squares(misfit, np.clip(start, low, high), bounds=(low, high))
        share = 1.0 - 2.0 * float(found.cost) / total
        values = {"m": (unit, low[0], high[0], float(found.x[0]))}
        if "/w" in text:
            values["w"] = (unit, low[1], high[1], float(found.x[1]))
        power = {"**2": "²", "**3": "³"}
        speed = UNITS["q"][not one.joints[one.index].turns]
        per = f"{torque}·s/{speed}" if one.factor == "speed" else torque
        per += f"/({unit}){power[text.split('- m)')[1][:3]]}" if "/w" not in text else ""
        out.append(Suggestion(text, share, {"c": per}, values))
    return tuple(sorted((s for s in out if s.share > 0.3), key=lambda s: -s.share))


def _word(one: Remainder) -> str:
    if one.variable == "load":
        return "tau_rigid"
    if one.variable == "t":
        return "t"
    kind, index = split_variable(one.variable)
    stem = {"q": "theta", "dq": "dtheta", "ddq": "ddtheta"}[kind]
    word = stem if index == one.index else f"{stem}{index + 1}"
    return f"abs({word})" if one.directed and stem == "dtheta" else word
