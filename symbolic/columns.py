"""The regressor in numbers: columns (J, N, P) of a model along a motion.

The rigid part comes from the derived equations (compiled where there is a compiler). A torque text is
linear and homogeneous in its coefficients, so its columns are its values with one coefficient at one and
the others at zero.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from symbolic.language.torque import Torque, is_transform, own_names, torques, uses_feedback
from symbolic.mechanics.friction import FRICTION
from symbolic.motion import Float, Motion
from symbolic.quantity import JOINTS

if TYPE_CHECKING:
    from symbolic.model import Model
    from symbolic.term import Term

RIGID = 4
"""Number of inertial parameters; friction has as many again."""
BASE = RIGID + len(FRICTION)


def needs_reference(model: Model) -> bool:
    """Whether some column depends on the linear parameters themselves."""
    from symbolic.codegen.kernel import compiled

    if any(uses_feedback(term) for term in model.terms):
        return True
    return bool(model.derived) and compiled(rigid_model(model)).needs_reference


def rigid_model(model: Model) -> Model:
    """Return the model with nothing but its mechanism: what has to be derived and compiled for its columns."""
    if len(model.derived) == len(model.terms):
        return model
    return replace(model, terms=model.derived)


def columns(model: Model, motion: Motion, shape: Float | None, reference: Float | None) -> Float:
    """Return the regressor (J, N, P); see Model.columns."""
    shapes = vector(shape, model.typical_shape, "shape")
    linear = carrying(motion, vector(reference, np.zeros(len(model.parameters)), "reference"))
    at = shape_values(model, shapes)
    place = places(model)
    out = np.zeros((len(JOINTS), len(motion), len(place)))
    _fill_base(model, motion, out, linear, at)
    env = environment(motion)
    if any(uses_feedback(term) for term in model.terms):
        env |= feedback(model, out, linear)
    plain = [term for term in model.terms if term.effect.derive is None and not is_transform(term)]
    for term in plain:
        _add(term, {**env, **shaped(term, at)}, motion, out, place)
    apply_transforms(model, out, shapes, motion)
    return out


def carrying(motion: Motion, linear: Float) -> Float:
    """Return linear parameters (P,) with what known payloads of `motion` add to Φ1..Φ4."""
    if motion.payload is None:
        return linear
    total = np.array(linear, dtype=float)
    total[:RIGID] += motion.payload
    return total


def derived_columns(model: Model, motion: Motion, shape: Float, reference: Float) -> Float:
    """Return the columns (J, N, m) of the model's last effect alone, one that changes the mechanism; arguments as of
    `columns`.
    """
    from symbolic.codegen.kernel import compiled

    count = len(model.terms[-1].effect.coefficients)
    if any(is_transform(term) for term in model.terms):
        return columns(model, motion, shape, reference)[:, :, len(model.parameters) - count :]
    bare, at = rigid_model(model), shape_values(model, shape)
    shapes = np.array([at[name] for name in (s.name for s in bare.shapes)])
    chosen = base_places(model)
    return compiled(bare).pointwise(motion, carrying(motion, reference)[chosen], shapes, len(chosen) - count)


_KEPT: WeakKeyDictionary[Motion, tuple[tuple[float, float], Float]] = WeakKeyDictionary()
"""Base columns of the plain leg along motions that are still in use, with its (thigh length, gravity)."""
LONGEST_KEPT = 400_000
"""Samples of a motion whose base columns are kept, at most: 50 MB."""


def _fill_base(model: Model, motion: Motion, out: Float, linear: Float, at: Mapping[str, float]) -> None:
    """Write the columns of mechanism and friction into `out`."""
    from symbolic.codegen.kernel import compiled

    chosen = base_places(model)
    if not model.derived and len(motion) <= LONGEST_KEPT:
        # A search asks for the same motion thousands of times, each time with another effect.
        size = model.thigh_length, model.gravity
        kept = _KEPT.get(motion)
        if kept is None or kept[0] != size:
            kept = _KEPT[motion] = size, compiled(model.base()).pointwise(motion, np.zeros(BASE), np.zeros(0))
        out[:, :, :BASE] = kept[1]
        return
    bare = rigid_model(model)
    shapes = np.array([at[name] for name in (s.name for s in bare.shapes)])
    out[:, :, chosen] = compiled(bare).pointwise(motion, linear[chosen], shapes)


def places(model: Model) -> dict[str, int]:
    """Return {parameter name: its column}."""
    return {parameter.name: k for k, parameter in enumerate(model.parameters)}


def base_places(model: Model) -> list[int]:
    """Return the columns of the base model: inertia, friction, and what changes the mechanism."""
    derived = {term.name for term in model.derived}
    return [k for k, p in enumerate(model.parameters) if p.term is None or p.term in derived]


def shape_values(model: Model, shapes: Float) -> dict[str, float]:
    """Return {full name: value} of the shapes (S,)."""
    return {s.name: float(value) for s, value in zip(model.shapes, shapes, strict=True)}


def shaped(term: Term, at: Mapping[str, float]) -> dict[str, float]:
    """Return {name in the effect: value} of a term's shapes."""
    return {key: at[f"{term.name}.{key}"] for key in term.effect.shape}


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


def feedback(model: Model, out: Float, linear: Float) -> dict[str, Float]:
    """Return tau_rigid and tau_model of both joints from the base columns in `out` and reference parameters
    (P,).

    They are never taken from a measurement: that would leak the answer into the question.
    """
    base = base_places(model)
    rigid = [k for k in base if not RIGID <= k < BASE]
    env: dict[str, Float] = {}
    for j in range(len(JOINTS)):
        env[f"tau_rigid{j + 1}"] = out[j][:, rigid] @ linear[rigid]
        env[f"tau_model{j + 1}"] = out[j][:, base] @ linear[base]
    return env


def apply_transforms(model: Model, out: Float, shapes: Float, motion: Motion) -> None:
    """Add to the base columns in `out` (J, N, P) what the transforms of the model make of them."""
    transforms = [term for term in model.terms if is_transform(term)]
    if not transforms:
        return
    base, at, env = base_places(model), shape_values(model, shapes), environment(motion)
    untouched = out[:, :, base].copy()
    for term in transforms:
        _transform(term, untouched, base, {**env, **shaped(term, at)}, motion, out)


def evaluate(torque: Torque, env: dict[str, Float | float], motion: Motion, count: int | None = None) -> Float:
    """Return the torque (N,) at its joint for the words in `env`.

    With `count` the shape values in `env` are columns (V, 1) of as many nodes, and the result is (V, N); for texts
    without memory.
    """
    from symbolic.language.lower import to_numpy

    own = {word: env[canonical] for word, canonical in own_names(torque.joint).items() if canonical in env}
    values = to_numpy(torque.node, {**env, **own}, own_signs(motion, torque.joint))
    whole = (len(motion),) if count is None else (count, len(motion))
    return np.broadcast_to(np.asarray(values, dtype=float), whole)


def own_signs(motion: Motion, joint: int) -> dict[str, Float]:
    """Return the sign signal of each word for a joint velocity."""
    return {"dtheta1": motion.sign[:, 0], "dtheta2": motion.sign[:, 1], "dtheta": motion.sign[:, joint]}


def _add(term: Term, env: dict[str, Float | float], motion: Motion, out: Float, place: dict[str, int]) -> None:
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
