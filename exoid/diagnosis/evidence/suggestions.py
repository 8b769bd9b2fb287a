"""Closed forms that come close to a learnt curve, in the torque language, to be pasted into a model."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np

from exoid.diagnosis.evidence.curves import split_variable, variables
from exoid.diagnosis.evidence.remainder import Remainder, Suggestion
from exoid.ground.ties import ascending, index_of_least
from exoid.symbolic.motion import Float

PLACES, WIDTHS = np.linspace(0.02, 0.98, 25), np.geomspace(0.01, 0.9, 9)
"""Where between its bounds a number is tried first: the place of a curve, and its width."""
ABOUT, FINER, ROUNDS = np.linspace(-0.1, 0.1, 7), 0.7, 40
"""Where about the best one numbers are tried next, how much nearer every time, and how many times."""


def suggest(one: Remainder) -> tuple[Suggestion, ...]:
    """Return closed forms for a learnt curve, best first: a bump, a step, a wave, powers."""
    word = _word(one)
    x, y = one.x, one.y - one.y.mean()
    torque = one.joints[one.index].unit("tau")
    unit = torque if one.variable == "load" else variables(one.joints)[one.variable][1]
    span = float(np.ptp(x))
    factor = {"sign": " * sgn(dtheta)", "speed": " * dtheta"}.get(one.factor, "")
    forms = (
        (f"c * exp(-(({word} - m)/w)**2){factor}", lambda p: np.exp(-(((x - p[0]) / p[1]) ** 2))),
        (f"c * tanh(({word} - m)/w){factor}", lambda p: np.tanh((x - p[0]) / p[1])),
        (f"c * ({word} - m)**2{factor}", lambda p: (x - p[0]) ** 2),
        (f"c * ({word} - m)**3{factor}", lambda p: (x - p[0]) ** 3),
    )
    out = []
    total = float(np.sum(y**2))
    if not total:
        return ()
    for text, shape in forms:
        numbers = 2 if "/w" in text else 1
        low = np.array([x.min() - 0.2 * span, 0.02 * span][:numbers])
        high = np.array([x.max() + 0.2 * span, 1.5 * span][:numbers])

        def misfit(p: Float, shape: Any = shape) -> Float:
            g = shape(p[..., None])
            g = g - g.mean(axis=-1, keepdims=True)
            c = (g @ y) / np.maximum(np.sum(g * g, axis=-1), 1e-300)
            return np.asarray(y - c[..., None] * g)

        best, left = _least_squares(misfit, low, high)
        share = 1.0 - left / total
        values = {"m": (unit, low[0], high[0], float(best[0]))}
        if "/w" in text:
            values["w"] = (unit, low[1], high[1], float(best[1]))
        power = {"**2": "²", "**3": "³"}
        per = f"{torque}·s/{one.joints[one.index].unit('q')}" if one.factor == "speed" else torque
        per += f"/({unit}){power[text.split('- m)')[1][:3]]}" if "/w" not in text else ""
        out.append(Suggestion(text, share, {"c": per}, values))
    return tuple(ascending((s for s in out if s.share > 0.3), lambda s: -s.share, 1.0))


def _least_squares(misfit: Callable[[Float], Float], low: Float, high: Float) -> tuple[Float, float]:
    """Point between `low` and `high` (S,) where the sum of squares of `misfit`, which takes (S, ...), is lowest, and
    that sum: the best of a grid over all of it, then of finer and finer ones about the best.
    """
    tried = np.array(list(itertools.product(PLACES, WIDTHS)))[:, : len(low)]
    about = np.array(list(itertools.product(*[ABOUT] * len(low))))
    for k in range(ROUNDS):
        squares = np.sum(misfit((low + tried * (high - low)).T) ** 2, axis=1)
        best = index_of_least(squares)
        at, left = tried[best], float(squares[best])
        tried = np.clip(at + FINER**k * about, 0.0, 1.0)
    return low + at * (high - low), left


def _word(one: Remainder) -> str:
    if one.variable == "load":
        return "tau_rigid"
    if one.variable == "t":
        return "t"
    kind, index = split_variable(one.variable)
    stem = {"q": "theta", "dq": "dtheta", "ddq": "ddtheta"}[kind]
    word = stem if index == one.index else f"{stem}{index + 1}"
    return f"abs({word})" if one.directed and stem == "dtheta" else word
