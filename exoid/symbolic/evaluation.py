"""The words of a torque text in numbers: signals of a motion, shapes, the model's own torque, and what texts make of
them.

Needs no equations: the base columns that tau_rigid, tau_model and transforms act on are handed in.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.symbolic.language.lower import to_numpy
from exoid.symbolic.language.torque import Torque, torques, transforms
from exoid.symbolic.language.tree import Call
from exoid.symbolic.motion import Float, Motion

if TYPE_CHECKING:
    from exoid.symbolic.model_structure import ModelStructure
    from exoid.symbolic.term import Term


def column_count(model: ModelStructure) -> int:
    """Number of columns of `whole_columns`: one per parameter, and one more where forces are measured."""
    return len(model.parameters) + bool(model.forces)


def carrying(model: ModelStructure, motion: Motion, linear: Float) -> Float:
    """Return linear parameters (P,) with what known payloads of `motion` add to Φ1..Φ4; where the model has measured
    forces one more, 1, of what these make without a number.
    """
    if motion.payload is None and not model.forces:
        return linear
    total = np.concatenate([linear, np.ones(column_count(model) - len(linear))])
    if motion.payload is not None:
        total[: len(motion.payload)] += motion.payload
    return total


def forces_of(motion: Motion, count: int) -> Float:
    """Return the measured forces (N, C) of `count` columns along a motion, zero where it has none: a motion that is
    only planned; ValueError where it has others.
    """
    if motion.force is None:
        return np.zeros((len(motion), count))
    if motion.force.shape[1] != count:
        raise ValueError(f"motion.force has {motion.force.shape[1]} columns, the model has {count}")
    return motion.force


def places(model: ModelStructure) -> dict[str, int]:
    """Return {parameter name: its column}."""
    return {parameter.name: k for k, parameter in enumerate(model.parameters)}


def base_places(model: ModelStructure) -> list[int]:
    """Return the columns of the base model: inertia, friction, measured forces, and what changes the mechanism."""
    derived = {term.name for term in model.derived}
    own = [k for k, p in enumerate(model.parameters) if p.term is None or p.term in derived]
    return own + [len(model.parameters)] * bool(model.forces)


def rigid_places(model: ModelStructure) -> list[int]:
    """Return those of them that make the rigid-body torque: without friction and without forces from outside."""
    outside = range(model.friction.start, model.base_count)
    return [k for k in base_places(model) if k not in outside and k < len(model.parameters)]


def shape_values(model: ModelStructure, shapes: Float) -> dict[str, float]:
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


def motion_words(motion: Motion) -> dict[str, Float | float]:
    """Return the words a torque text may use for the motion itself."""
    return dict(motion.words)


def feedback(
    model: ModelStructure, terms: Iterable[Term], base: Float, linear: Float, motion: Motion
) -> dict[str, Float]:
    """Return tau_rigid and tau_model of the joints of which `terms` speak, as `fed_back` has them."""
    used = {name for term in terms for torque in torques(term) for name in torque.names}
    return fed_back(model, base, linear, motion, used)


def fed_back(
    model: ModelStructure, base: Float, linear: Float, motion: Motion, used: Collection[str] | None = None
) -> dict[str, Float]:
    """Return tau_rigid and tau_model (N,) of all joints, or those of them that are `used`, from the columns (J, N, B)
    at `base_places` and reference parameters (P,), with the load of `motion`.

    They are never taken from a measurement: that would leak the answer into the question.
    """
    whole = base_places(model)
    every = np.concatenate([linear, np.ones(max(0, 1 + max(whole) - len(linear)))])[whole]
    rigid = np.where(np.isin(whole, rigid_places(model)), every, 0.0)
    return {
        f"{word}{j + 1}": columns @ numbers + (0.0 if motion.load is None else motion.load[:, j])
        for word, numbers in (("tau_rigid", rigid), ("tau_model", every))
        for j, columns in enumerate(base)
        if used is None or f"{word}{j + 1}" in used
    }


def apply_transforms(model: ModelStructure, out: Float, shapes: Float, motion: Motion) -> None:
    """Add to torques, or columns of them, in `out` (J, N, P) what the transforms of the model make of these, each once:
    they are linear.
    """
    acting = transforms(model.terms)
    if not acting:
        return
    at, env = shape_values(model, shapes), motion_words(motion)
    rows = np.array(np.swapaxes(out, 1, 2), order="C")  # a copy: `out` changes
    words = {f"tau_model{j + 1}": row for j, row in enumerate(rows)}
    for term in acting:
        for torque in torques(term):
            heard = [row for word, row in words.items() if word in torque.names]
            some = np.flatnonzero(np.any(heard, axis=(0, 2)))  # of nothing it makes nothing
            if some.size:
                acted = {**env, **shaped(term, at), **{word: row[some] for word, row in words.items()}}
                out[torque.joint, :, some] += torque_values(torque, acted, motion, count=some.size)


def torque_values(
    torque: Torque,
    env: dict[str, Float | float],
    motion: Motion,
    count: int | None = None,
    kept: dict[Call, Any] | None = None,
) -> Float:
    """Return the torque (N,) at its joint for the words in `env`.

    With `count` the shape values in `env` are columns (V, 1) of as many nodes, and the result is (V, N). `kept` is as
    of `to_numpy`.
    """
    values = to_numpy(torque.node, env, motion.signs, kept)
    whole = (len(motion),) if count is None else (count, len(motion))
    return np.broadcast_to(np.asarray(values, dtype=float), whole)
