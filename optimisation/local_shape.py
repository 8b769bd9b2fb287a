"""Shape parameters beside a start, and those that belong to one recording.

Where a stop is met moves with strapping and encoder zero: each recording has its own place, while the stiffness is the
leg's. Such values (`Shape.per_recording`) are fitted to every recording, an unseen one included; the linear parameters
never are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from optimisation.loss import huber
from symbolic.model import Model
from symbolic.motion import Float

if TYPE_CHECKING:
    from optimisation.fit import Fit
    from optimisation.prepare import Prepared, PreparedRecording

SWEEPS = 6
"""Rounds of coordinate descent at most."""
SETTLED = 1e-7
"""Relative fall of the loss below which coordinate descent stops."""


def own_shapes(model: Model) -> tuple[int, ...]:
    """Return the indices of shape parameters that each recording has to itself."""
    return tuple(i for i, s in enumerate(model.shapes) if s.shape.per_recording)


def shapes_for(fit: Fit, prepared: Prepared) -> Float:
    """Return shape values (R, S) for all recordings: fitted ones for training, own ones found for verification."""
    model: Model = fit.model  # type: ignore[assignment]
    train = np.broadcast_to(fit.shapes, (len(prepared.train), len(model.shapes)))
    own = own_shapes(model)
    rows = [
        _fit_own(model, one, fit.linear, np.array(fit.shape), own, fit.delta) if own else np.array(fit.shape)
        for one in prepared.verify
    ]
    return np.array([*train, *rows], dtype=float).reshape(len(prepared.all), len(model.shapes))


def _fit_own(
    model: Model, one: PreparedRecording, linear: Float, shape: Float, own: Sequence[int], delta: Float
) -> Float:
    """Return `shape` with the values of index `own` fitted to one recording, everything else fixed."""
    from optimisation.assemble import assemble

    def loss(values: Float) -> float:
        data = assemble(model, [one], values, linear if model.needs_reference else None)
        return huber(data.residual(linear), delta)

    best = shape.copy()
    for _ in range(2 if len(own) > 1 else 1):
        for index in own:
            entry = model.shapes[index].shape
            joint = 0 if model.shapes[index].term.endswith(":hip") else 1
            path = one.motion.q[:, joint] if entry.spacing == "position" else np.array([entry.min, entry.max])
            trials = np.linspace(max(entry.min, path.min()), min(entry.max, path.max()), 24)
            values = [loss(_with(best, index, v)) for v in trials]
            k = int(np.argmin(values))
            low, high = trials[max(k - 1, 0)], trials[min(k + 1, len(trials) - 1)]
            best = _with(best, index, _minimum(lambda v, i=index: loss(_with(best, i, v)), low, high))
    return best


def _with(shape: Float, index: int, value: float) -> Float:
    out = shape.copy()
    out[index] = value
    return out


def _minimum(function: Callable[[float], float], low: float, high: float) -> float:
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(function, bounds=(low, high), method="bounded", options={"xatol": 1e-4 * (high - low)})
    return float(found.x)


def descend(loss: Callable[[Float], float], model: Model, start: Float, reach: Float) -> Float:
    """Return shape values (R, S) near `start` with a smaller loss ((R, S) -> float): coordinate descent.

    `reach` (S,) is how far a coordinate may move in one sweep; a value that is not per recording moves in all rows.
    """
    best, value = np.array(start, dtype=float), loss(start)
    for _ in range(SWEEPS):
        before = value
        for index, entry in enumerate(model.shapes):
            if entry.shape.choices:
                continue
            rows = [[r] for r in range(len(best))] if entry.shape.per_recording else [list(range(len(best)))]
            for group in rows:
                best, value = _move(loss, best, value, index, group, reach[index], entry.shape.min, entry.shape.max)
        if before - value <= SETTLED * max(before, 1e-300):
            break
    return best


def _move(
    loss: Callable[[Float], float],
    best: Float,
    value: float,
    index: int,
    rows: list[int],
    reach: float,
    least: float,
    most: float,
) -> tuple[Float, float]:
    at = float(best[rows[0], index])

    def moved(v: float) -> Float:
        out = best.copy()
        out[rows, index] = v
        return out

    found = _minimum(lambda v: loss(moved(v)), max(least, at - reach), min(most, at + reach))
    reached = loss(moved(found))
    return (moved(found), reached) if reached < value else (best, value)


def reach(model: Model, prepared: Sequence[PreparedRecording]) -> Float:
    """Return how far (S,) a shape value may move in one sweep: a grid step, or a tenth of the joint's path."""
    out = []
    for entry in model.shapes:
        shape = entry.shape
        width = shape.max - shape.min
        if shape.spacing == "position":
            joint = 0 if entry.term.endswith(":hip") else 1
            path = np.concatenate([p.motion.q[:, joint] for p in prepared])
            out.append(0.1 * float(np.ptp(path)))
        else:
            out.append(width / max(2, shape.points - 1))
    return np.array(out)
