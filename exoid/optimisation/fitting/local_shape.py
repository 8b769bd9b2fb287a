"""Shape parameters beside a start, and those that belong to one recording.

Some values belong to a recording by nature (by how much its clock is late, the phase of a sway), or because mounting
and strapping move a place. They (`Shape.per_recording`) are fitted to every recording, an unseen one included, but
judged on the half of it that they were not fitted to; the linear parameters never are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.ground.minimum import minimum
from exoid.ground.ties import index_of_least
from exoid.optimisation.linear.loss import huber, huber_terms
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

if TYPE_CHECKING:
    from exoid.optimisation.fitting.fit import Fit
    from exoid.optimisation.fitting.shape_problem import ShapeProblem
    from exoid.optimisation.preparation.filtering import PreparedRecording
    from exoid.optimisation.preparation.prepare import Prepared

SWEEPS = 10
"""Rounds of a descent at most."""
MOST_OWN = 40
"""Values that recordings have to themselves at most that take part in a Gauss-Newton step, for speed."""
HALVINGS = 5
"""Times a step is halved before it is given up."""
DIFFERENCE = 1e-4
"""Step of a derivative, as a share of the range of the shape."""
NUDGE = 2e-4
"""To what share of its reach a recording's own value is moved."""
SETTLED = 1e-6
"""Relative fall of the loss below which a descent stops."""


def own_shapes(model: Model) -> tuple[int, ...]:
    """Return the indices of shape parameters that each recording has to itself."""
    return tuple(i for i, s in enumerate(model.shapes) if s.shape.per_recording)


def shapes_for(fit: Fit, prepared: Prepared) -> Float:
    """Return shape values (R, S) for all recordings: fitted ones for training, own ones found for verification."""
    model: Model = fit.model
    train = np.broadcast_to(fit.shapes, (len(prepared.train), len(model.shapes)))
    own = own_shapes(model)
    rows = [
        _fit_own(fit, recording, own) if own else np.array(fit.shape)
        for recording in prepared.verify
    ]
    return np.array([*train, *rows], dtype=float).reshape(len(prepared.all), len(model.shapes))


def own_of_halves(fit: Fit, one: PreparedRecording) -> Float:
    """Return the shape values (2, S) by which the two halves of a recording are judged: its own ones fitted to the
    other half.
    """
    own = own_shapes(fit.model)
    early = np.arange(one.used.shape[1]) < one.used.shape[1] // 2
    halves = (one.changed(used=one.used & part) for part in (~early, early))
    return np.array([_fit_own(fit, half, own) for half in halves])


def _fit_own(fit: Fit, one: PreparedRecording, own: Sequence[int]) -> Float:
    """Return the shape of `fit` with the values of index `own` fitted to one recording, everything else fixed."""
    model, best = fit.model, np.array(fit.shape)
    for _ in range(2 if len(own) > 1 else 1):
        for index in own:
            entry = model.shapes[index].shape
            joint = shape_joint(model, model.shapes[index])
            path = one.motion.q[:, joint] if entry.spacing == "position" else np.array([entry.min, entry.max])
            trials = np.linspace(max(entry.min, path.min()), min(entry.max, path.max()), 24)
            losses = _own_losses(model, one, fit.linear, best, index, fit.limits, fit.weight)
            k = index_of_least(losses(trials))
            low, high = trials[max(k - 1, 0)], trials[min(k + 1, len(trials) - 1)]
            best[index] = minimum(_one_by_one(losses), low, high, NUDGE * (high - low))[0]
    return best


def _own_losses(
    model: Model, one: PreparedRecording, linear: Float, shape: Float, index: int, delta: Float, weight: Float
) -> Callable[[Float], Float]:
    """Function that gives the Huber losses (V,) on one recording at V values of shape `index`, everything else held,
    with weighted joints; torques pass the filter, not columns: it is linear.
    """
    still, joints, moving = model.moving_torque(one.motion, linear, shape, index)
    use, own = one.used, list(joints)
    rest = np.where(use, one.torque - one.smooth(still), 0.0) * weight[:, None]
    others = np.setdiff1d(np.arange(len(rest)), own)
    known = huber(rest[others], delta[others])

    def losses(values: Float) -> Float:
        moved = one.smooth_rows(moving(values), joints, 1)
        size = np.abs(rest[own] - np.where(use[own], moved, 0.0) * weight[own][:, None])
        return np.asarray(known + np.sum(huber_terms(size, delta[own][:, None]), axis=(1, 2)))

    return losses


def _one_by_one(losses: Callable[[Float], Float]) -> Callable[[float], float]:
    return lambda value: float(losses(np.array([value]))[0])


def descend(problem: ShapeProblem, start: Float, delta: Float) -> Float:
    """Return shape values (R, S) near `start` with a smaller loss.

    What a recording has to itself is fitted to that recording with the linear parameters held, then all of them by
    Gauss-Newton steps taken together with the linear parameters (variable projection); in turn, where they are too many
    for such steps.
    """
    model, prepared = problem.assembly.model, problem.assembly.prepared
    far = reach(model, prepared)
    own = own_shapes(model)
    shared = [i for i, s in enumerate(model.shapes) if not s.shape.choices and i not in own]
    together = own if len(start) * len(own) <= MOST_OWN else ()
    best, value = np.array(start, dtype=float), problem.loss(start)
    for sweep in range(SWEEPS):
        settled, before = SETTLED * max(value, 1e-300), value
        if own and not (sweep and together):
            linear = problem.solved(best).linear
            moved = np.array(
                [
                    _nudge(model, recording, linear, row, far, delta, problem.assembly.weight)
                    for recording, row in zip(prepared, best, strict=True)
                ]
            )
            if (reached := problem.loss(moved)) < value:
                best, value = moved, reached
        apart = value
        if shared or together:
            best, value = _step(problem, model, best, value, (shared, together), far, delta)
        if before - value <= settled or (together and apart - value <= settled):
            break
    return best


def _step(
    problem: ShapeProblem,
    model: Model,
    shapes: Float,
    value: float,
    moving: tuple[Sequence[int], Sequence[int]],
    far: Float,
    delta: Float,
) -> tuple[Float, float]:
    """Return the shapes and the loss after one Gauss-Newton step, halved until it helps; unchanged where none does that
    promises more than the fall at which a descent stops.

    `moving` are the indices of shape values that all recordings share, and of those that each has to itself.
    """
    linear = problem.solved(shapes).linear
    here = problem.data(shapes, linear)
    residual = here.residual(linear)
    slopes, places, (shared, own) = [], [], moving
    for index in (*shared, *own):
        entry = model.shapes[index].shape
        h = DIFFERENCE * (entry.max - entry.min)
        up, down = shapes.copy(), shapes.copy()
        up[:, index] = np.minimum(shapes[:, index] + h, entry.max)
        down[:, index] = np.maximum(shapes[:, index] - h, entry.min)
        rise = problem.data(down, linear).residual(linear) - problem.data(up, linear).residual(linear)
        slope = rise / (up - down)[here.groups if index in own else 0, index]
        for row in range(len(shapes)) if index in own else (slice(None),):
            slopes.append(slope if index in shared else np.where(here.groups == row, slope, 0.0))
            places.append((row, index))
    jacobian = np.concatenate([here.columns, np.stack(slopes, axis=2)], axis=2)
    weight = np.sqrt(np.minimum(1.0, delta[:, None] / np.maximum(np.abs(residual), 1e-300)))
    scale = np.sqrt(np.sum(jacobian**2, axis=(0, 1)))
    scale = np.where(scale > 0.0, scale, 1.0)
    matrix = (jacobian / scale * weight[:, :, None]).reshape(-1, jacobian.shape[2])
    gram, right = matrix.T @ matrix, matrix.T @ (weight * residual).ravel()
    whole = np.linalg.lstsq(gram, right, rcond=1e-10)[0]
    promised, step = float(right @ whole), (whole / scale)[here.columns.shape[2] :]
    most = 2.0 * far[[index for _, index in places]]
    step = np.clip(step, -most, most)
    for _ in range(HALVINGS):
        if promised <= SETTLED * value:
            break
        trial = shapes.copy()
        for (row, index), change in zip(places, step, strict=True):
            entry = model.shapes[index].shape
            trial[row, index] = np.clip(shapes[row, index] + change, entry.min, entry.max)
        reached = problem.loss(trial)
        if reached < value:
            return trial, reached
        promised, step = 0.5 * promised, 0.5 * step
    return shapes, value


def _nudge(
    model: Model, one: PreparedRecording, linear: Float, shape: Float, far: Float, delta: Float, weight: Float
) -> Float:
    """Return one recording's shape values with its own ones moved to a smaller loss, linear parameters held."""
    best = shape.copy()
    for index in own_shapes(model):
        entry = model.shapes[index].shape
        loss = _one_by_one(_own_losses(model, one, linear, best, index, delta, weight))
        at = float(best[index])
        low, high = max(entry.min, at - far[index]), min(entry.max, at + far[index])
        found, least = minimum(loss, low, high, NUDGE * (high - low))
        best[index] = found if least < loss(at) else at
    return best


def shape_joint(model: Model, entry: Any) -> int:
    """Return the index of the joint whose effect has the shape parameter `entry`; the last for an effect on several."""
    names = [joint.name for joint in model.joints]
    place = entry.term.rpartition(":")[2]
    return names.index(place) if place in names else len(names) - 1


def reach(model: Model, prepared: Sequence[PreparedRecording]) -> Float:
    """Farthest move (S,) of a shape value in one sweep: a grid step, or a tenth of the joint's path."""
    out = []
    for entry in model.shapes:
        shape = entry.shape
        width = shape.max - shape.min
        if shape.spacing == "position":
            joint = shape_joint(model, entry)
            path = np.concatenate([p.motion.q[:, joint] for p in prepared])
            out.append(0.1 * float(np.ptp(path)))
        else:
            out.append(width / max(2, shape.points - 1))
    return np.array(out)
