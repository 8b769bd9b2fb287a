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
    from optimisation.assemble import FittableModel
    from optimisation.assemble import Prepared as Working
    from optimisation.fit import Fit
    from optimisation.prepare import Prepared, PreparedRecording

SWEEPS = 6
"""Rounds of coordinate descent at most."""
SETTLED = 1e-6
"""Relative fall of the loss below which coordinate descent stops."""


def own_shapes(model: FittableModel) -> tuple[int, ...]:
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
            best = _scan(loss, best, index, trials)
    return best


def _scan(loss: Callable[[Float], float], shape: Float, index: int, trials: Float) -> Float:
    """Return `shape` with value `index` at the best of `trials`, refined between its neighbours."""
    k = int(np.argmin([loss(_with(shape, index, v)) for v in trials]))
    low, high = trials[max(k - 1, 0)], trials[min(k + 1, len(trials) - 1)]
    return _with(shape, index, _minimum(lambda v: loss(_with(shape, index, v)), low, high))


def _with(shape: Float, index: int, value: float) -> Float:
    out = shape.copy()
    out[index] = value
    return out


def _minimum(function: Callable[[float], float], low: float, high: float) -> float:
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(function, bounds=(low, high), method="bounded", options={"xatol": 2e-4 * (high - low)})
    return float(found.x)


Loss = Callable[[Float], float]
Settle = Callable[[Float], Float]


def descend(
    loss: Loss, settled: Settle, model: FittableModel, prepared: Sequence[Working], start: Float, delta: Float
) -> Float:
    """Return shape values (R, S) near `start` with a smaller loss ((R, S) -> float): coordinate descent.

    `settled` ((R, S) -> (P,)) gives the linear parameters there. What a recording has to itself is fitted to that
    recording with the linear parameters held; everything else with the linear parameters solved anew at every trial.
    """
    far = reach(model, prepared)
    own = own_shapes(model)
    best, value = np.array(start, dtype=float), loss(start)
    for _ in range(SWEEPS):
        before = value
        if own:
            linear = settled(best)
            rows = [_nudge(model, one, linear, row, far, delta) for one, row in zip(prepared, best, strict=True)]
            if (reached := loss(np.array(rows))) < value:
                best, value = np.array(rows), reached
        for index, entry in enumerate(model.shapes):
            if not entry.shape.choices and index not in own:
                every = list(range(len(best)))
                best, value = _move(loss, best, value, index, every, far[index], entry.shape.min, entry.shape.max)
        if before - value <= SETTLED * max(before, 1e-300):
            break
    return best


def _nudge(model: FittableModel, one: Working, linear: Float, shape: Float, far: Float, delta: Float) -> Float:
    """Return one recording's shape values with its own ones moved to a smaller loss, linear parameters held."""
    from optimisation.assemble import Assembly

    assembly = Assembly(model, [one])
    best = shape.copy()
    for index in own_shapes(model):
        entry = model.shapes[index].shape

        def loss(v: float, base: Float = best, index: int = index) -> float:
            data = assembly.data(_with(base, index, v), linear if model.needs_reference else None)
            return huber(data.residual(linear), delta)

        at = float(best[index])
        found = _minimum(loss, max(entry.min, at - far[index]), min(entry.max, at + far[index]))
        best = _with(best, index, found) if loss(found) < loss(at) else best
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


def reach(model: FittableModel, prepared: Sequence[Working]) -> Float:
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
