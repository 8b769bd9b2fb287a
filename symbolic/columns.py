"""The regressor in numbers: columns (J, N, P) of a model along a motion.

The rigid part comes from the derived equations (compiled where there is a compiler). A torque text is
linear and homogeneous in its coefficients, so its columns are its values with one coefficient at one and
the others at zero.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from symbolic.friction import FRICTION
from symbolic.motion import Float, Motion
from symbolic.quantity import JOINTS
from symbolic.torque import Torque, is_transform, own_names, torques, uses_feedback

if TYPE_CHECKING:
    from symbolic.model import Model
    from symbolic.term import Term

RIGID = 4
"""Number of inertial parameters; friction has as many again."""
BASE = RIGID + len(FRICTION)


def needs_reference(model: Model) -> bool:
    """Whether some column depends on the linear parameters themselves."""
    from symbolic.rigid_columns import rigid_columns

    if any(uses_feedback(term) for term in model.terms):
        return True
    return bool(model.derived) and rigid_columns(model).needs_reference


def columns(model: Model, motion: Motion, shape: Float | None, reference: Float | None) -> Float:
    """Return the regressor (J, N, P); see Model.columns."""
    from symbolic.rigid_columns import rigid_columns

    shapes = vector(shape, model.typical_shape, "shape")
    linear = vector(reference, np.zeros(len(model.parameters)), "reference")
    place = {parameter.name: k for k, parameter in enumerate(model.parameters)}
    at = {s.name: float(value) for s, value in zip(model.shapes, shapes, strict=True)}
    out = np.zeros((len(JOINTS), len(motion), len(place)))

    form = rigid_columns(model)
    rigid = [place[name] for name in form.names]
    out[:, :, rigid] = form.evaluate(motion, np.array([at[name] for name in form.shapes]), linear[rigid])
    env = environment(motion)
    for k, term in enumerate(FRICTION):
        for torque in torques(term):
            out[torque.joint, :, RIGID + k] = evaluate(torque, {**env, "c": 1.0}, motion)
    base = sorted({*rigid, *range(BASE)})
    if model.terms:
        env |= feedback(out, rigid, base, linear)
    untouched = out[:, :, base].copy() if any(is_transform(term) for term in model.terms) else out
    for term in model.terms:
        shaped = {key: at[f"{term.name}.{key}"] for key in term.effect.shape}
        if is_transform(term):
            _transform(term, untouched, base, {**env, **shaped}, motion, out)
        else:
            _add(term, {**env, **shaped}, motion, out, place)
    return out


def vector(values: Float | None, default: Float, what: str) -> Float:
    """Return `values` as float64 of the default's length, or the default; ValueError where the length
    differs.
    """
    if values is None:
        return default
    given = np.asarray(values, dtype=float)
    if given.shape != default.shape:
        raise ValueError(f"{what} has shape {given.shape}, the model wants {default.shape}")
    return given


def environment(motion: Motion) -> dict[str, Float | float]:
    """Return the words a torque text may use for the motion itself."""
    env: dict[str, Float | float] = {"t": motion.t}
    for j in range(len(JOINTS)):
        env |= {
            f"theta{j + 1}": motion.q[:, j],
            f"dtheta{j + 1}": motion.dq[:, j],
            f"ddtheta{j + 1}": motion.ddq[:, j],
        }
    return env


def feedback(out: Float, rigid: list[int], base: list[int], linear: Float) -> dict[str, Float]:
    """Return tau_rigid and tau_model of both joints, computed from the reference parameters, never
    measured.
    """
    env: dict[str, Float] = {}
    for j in range(len(JOINTS)):
        env[f"tau_rigid{j + 1}"] = out[j][:, rigid] @ linear[rigid]
        env[f"tau_model{j + 1}"] = out[j][:, base] @ linear[base]
    return env


def evaluate(torque: Torque, env: dict[str, Float | float], motion: Motion) -> Float:
    """Return the torque (N,) at its joint for the words in `env`."""
    from symbolic.lower import to_numpy

    own = {word: env[canonical] for word, canonical in own_names(torque.joint).items() if canonical in env}
    values = to_numpy(torque.node, {**env, **own}, own_signs(motion, torque.joint))
    return np.broadcast_to(np.asarray(values, dtype=float), (len(motion),))


def own_signs(motion: Motion, joint: int) -> dict[str, Float]:
    """Return the sign signal of each word for a joint velocity."""
    return {"dtheta1": motion.sign[:, 0], "dtheta2": motion.sign[:, 1], "dtheta": motion.sign[:, joint]}


def _add(
    term: Term, env: dict[str, Float | float], motion: Motion, out: Float, place: dict[str, int]
) -> None:
    """Write the columns of an ordinary text into `out`."""
    keys = tuple(term.effect.coefficients)
    for torque in torques(term):
        for key in keys:
            if key in torque.names:
                unit = {other: float(other == key) for other in keys}
                out[torque.joint, :, place[f"{term.name}.{key}"]] = evaluate(torque, {**env, **unit}, motion)


def _transform(
    term: Term, untouched: Float, base: list[int], env: dict[str, Float | float], motion: Motion, out: Float
) -> None:
    """Add to each base column in `out` what the term makes of it."""
    for torque in torques(term):
        for k, column in enumerate(base):
            words = {f"tau_model{j + 1}": untouched[j, :, k] for j in range(len(JOINTS))}
            if np.any([np.any(values) for values in words.values()]):
                out[torque.joint, :, column] += evaluate(torque, {**env, **words}, motion)
