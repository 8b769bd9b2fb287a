"""The regressor in numbers: columns (J, N, P) of a model along a motion, and the torque they give.

The rigid part comes from the derived equations (compiled where there is a compiler). A torque text is
linear and homogeneous in its coefficients, so its columns are its values with one coefficient at one and
the others at zero.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np

from exoid.symbolic.codegen.kernel import compiled
from exoid.symbolic.evaluation import (
    apply_transforms,
    base_places,
    carrying,
    column_count,
    feedback,
    motion_words,
    places,
    rigid_places,
    shape_values,
    shaped,
    torque_values,
    vector,
)
from exoid.symbolic.language.deflection import STATES
from exoid.symbolic.language.torque import is_transform, part_of, torques, uses_feedback, uses_slopes
from exoid.symbolic.motion import Float, Motion
from exoid.symbolic.waves import FEW, Waves

if TYPE_CHECKING:
    from exoid.symbolic.model_structure import ModelStructure
    from exoid.symbolic.term import Term


MovingTorque = tuple[Float, tuple[int, ...], Callable[[Float], Float]]
"""What a shape value has no part in, the joints of the rest, and what gives that."""


def model_columns(
    model: ModelStructure, motion: Motion, shape: Float | None = None, reference: Float | None = None
) -> Float:
    """Return the regressor (J, N, P); see `Model.columns`."""
    return whole_columns(model, motion, shape, reference)[:, :, : len(model.parameters)]


def whole_columns(
    model: ModelStructure, motion: Motion, shape: Float | None = None, reference: Float | None = None
) -> Float:
    """Return `model_columns`, with one more where there are measured forces; see `Model.whole_columns`."""
    shapes = vector(shape, model.typical_shape, "shape")
    linear = carrying(model, motion, vector(reference, np.zeros(len(model.parameters)), "reference"))
    out = _untransformed(model, motion, shapes, linear)
    apply_transforms(model, out, shapes, motion)
    return out


def _untransformed(model: ModelStructure, motion: Motion, shapes: Float, linear: Float) -> Float:
    """Return the regressor (J, N, P) before terms that act on whole torques."""
    at = shape_values(model, shapes)
    place = places(model)
    out = np.zeros((len(model.joints), len(motion), column_count(model)))
    base = _base_columns(model, motion, linear, at)
    chosen = base_places(model)
    # A block of columns is copied several times faster than a list of them.
    out[:, :, slice(len(chosen)) if chosen == [*range(len(chosen))] else chosen] = base
    env = motion_words(motion)
    if any(uses_feedback(term) for term in model.terms):
        env |= feedback(model, model.terms, base, linear, motion)
        env |= slopes_of(model, model.terms, motion, linear, shapes)
    plain = [term for term in model.terms if term.effect.derive is None and not is_transform(term)]
    for term in plain:
        _add(term, {**env, **shaped(term, at)}, motion, out, place)
    return out


def following_places(model: ModelStructure) -> tuple[int, ...]:
    """Return the indices of the parameters whose columns follow the shapes; see `Model.following_places`."""
    found = tuple(term for term in model.terms if term.effect.shape or uses_feedback(term))
    further = _mechanism_follows(model) or any(t.effect.derive is not None or is_transform(t) for t in found)
    return () if further else _coefficients(model, found)


def held_places(model: ModelStructure) -> tuple[int, ...]:
    """Return the same where columns depend on the parameters and these are held; () where others may follow as well."""
    found = tuple(term for term in model.terms if term.effect.shape)
    if not needs_reference(model) or any(is_transform(term) for term in model.terms):
        return ()
    derived = [term for term in found if term.effect.derive is not None]
    if derived and (len(found) > 1 or found[0] is not model.terms[-1] or any(map(uses_feedback, model.terms))):
        return ()
    return _coefficients(model, found)


def _coefficients(model: ModelStructure, terms: Iterable[Term]) -> tuple[int, ...]:
    place = places(model)
    return tuple(place[f"{term.name}.{key}"] for term in terms for key in term.effect.coefficients)


def following_columns(
    model: ModelStructure, motion: Motion, chosen: Sequence[int], nodes: Float, reference: Float | None = None
) -> Float:
    """Return the columns (V, J, m, N) of the parameters `chosen`; see `Model.following_columns`."""
    names, words = [entry.name for entry in model.shapes], motion_words(motion)
    wanted = {model.parameters[k].term for k in chosen}
    terms = tuple(term for term in model.terms if term.name in wanted)
    numbers = vector(reference, np.zeros(len(model.parameters)), "reference")
    if terms[-1].effect.derive is not None:
        return derived_columns(model, motion, nodes, numbers)(nodes)
    if any(map(uses_feedback, terms)):
        carried = carrying(model, motion, numbers)
        base = _base_columns(model, motion, carried, shape_values(model, nodes[0]))
        words |= feedback(model, terms, base, carried, motion) | slopes_of(model, terms, motion, carried, nodes[0])
    width = sum(len(term.effect.coefficients) for term in terms)
    out, first = np.zeros((len(nodes), len(model.joints), width, len(motion))), 0
    for term in terms:
        keys = tuple(term.effect.coefficients)
        own = nodes[:, [names.index(f"{term.name}.{key}") for key in term.effect.shape]]
        tried, kept = {**words, **{key: own[:, [i]] for i, key in enumerate(term.effect.shape)}}, dict[Any, Any]()
        for torque in torques(term):
            for m, key in enumerate(keys):
                if key in torque.names:
                    part = part_of(torque, key, keys)
                    out[:, torque.joint, first + m] = torque_values(part, tried, motion, len(nodes), kept)
        first += len(keys)
    return out


def model_torque(model: ModelStructure, motion: Motion, linear: Any, shape: Float | None = None) -> Float:
    """Return the torque (N, J) in N·m that the model says `motion` takes, for linear parameters (P,)."""
    values = np.asarray(linear, dtype=float)
    if values.shape != (len(model.parameters),):
        raise ValueError(f"linear has shape {values.shape}, the model has {len(model.parameters)} parameters")
    shapes, carried = vector(shape, model.typical_shape, "shape"), carrying(model, motion, values)
    out = (_untransformed(model, motion, shapes, carried) @ carried)[:, :, None]
    apply_transforms(model, out, shapes, motion)
    return np.asarray(out[:, :, 0].T)


def forces_torque(model: ModelStructure, motion: Motion, linear: Float) -> Float:
    """Return the torques that measured forces alone ask of the drives (N, J), for linear parameters (P,) of a model
    without terms; zero for a model without forces.
    """
    if not model.forces:
        return np.zeros(motion.q.shape)
    numbers = carrying(model, motion, np.where(np.arange(len(linear)) < model.friction.stop, 0.0, linear))
    if motion.payload is not None:
        numbers[: len(motion.payload)] = 0.0
    return np.asarray((whole_columns(model, motion) @ numbers).T)


def moving_torque(
    model: ModelStructure, motion: Motion, linear: Float, shape: Float, index: int
) -> MovingTorque:
    """Return the torque that shape value `index` has no part in, and what gives the rest; see `Model.moving_torque`."""
    entry, at = model.shapes[index], shape_values(model, shape)
    term = next(term for term in model.terms if term.name == entry.term)
    if term.effect.derive is not None or any(is_transform(other) for other in model.terms if other is not term):

        def whole(values: Float) -> Float:
            trials = np.tile(shape, (len(values), 1))
            trials[:, index] = values
            return np.stack([model_torque(model, motion, linear, trial).T for trial in trials])

        return np.zeros((len(motion), len(model.joints))), tuple(range(len(model.joints))), whole
    carried = carrying(model, motion, linear)
    columns = _untransformed(model, motion, shape, carried)
    own = {key: places(model)[f"{term.name}.{key}"] for key in term.effect.coefficients}
    words = {**motion_words(motion), **shaped(term, at), **{key: float(carried[place]) for key, place in own.items()}}
    if is_transform(term):
        words |= {f"tau_model{j + 1}": values for j, values in enumerate(columns @ carried)}
    elif uses_feedback(term):
        words |= feedback(model, (term,), columns[:, :, base_places(model)], carried, motion)
        words |= slopes_of(model, (term,), motion, carried, shape)
    still = np.array(carried)
    still[[*own.values()]] = 0.0
    texts = torques(term)
    joints = tuple(sorted({text.joint for text in texts}))

    def moved(values: Float) -> Float:
        tried, kept = {**words, entry.name.removeprefix(f"{term.name}."): values[:, None]}, dict[Any, Any]()
        out = np.zeros((len(values), len(joints), len(motion)))
        for text in texts:
            out[:, joints.index(text.joint)] += torque_values(text, tried, motion, len(values), kept)
        return out

    return (columns @ still).T, joints, moved


def needs_reference(model: ModelStructure) -> bool:
    """True if some column depends on the linear parameters themselves."""
    return any(uses_feedback(term) for term in model.terms) or _mechanism_follows(model)


def _mechanism_follows(model: ModelStructure) -> bool:
    """True if columns of the mechanism itself depend on the linear parameters."""
    return bool(model.derived) and compiled(rigid_model(model)).needs_reference


def reference_places(model: ModelStructure) -> tuple[int, ...]:
    """Return the indices of the linear parameters that columns depend on; () where they depend on none."""
    if not needs_reference(model):
        return ()
    if model.derived:
        return tuple(range(len(model.parameters)))
    names = {name for term in model.terms for torque in torques(term) for name in torque.names}
    friction = any(name.startswith("tau_model") for name in names)
    followed = base_places(model) if friction else rigid_places(model)
    return tuple(k for k in followed if k < len(model.parameters))


def rigid_model(model: ModelStructure) -> ModelStructure:
    """Return the model with nothing but its mechanism: what has to be derived and compiled for its columns."""
    if len(model.derived) == len(model.terms):
        return model
    return replace(model, terms=model.derived)


def slopes_of(
    model: ModelStructure, terms: Iterable[Term], motion: Motion, linear: Float, shapes: Float
) -> dict[str, Float]:
    """Return {word: values (N,)} of the derivatives of the rigid-body torque that the texts of `terms` speak of.

    `linear` (P,) and `shapes` (S,) are numbers of `model`, known payloads included.
    """
    used = {name for term in terms if uses_slopes(term) for torque in torques(term) for name in torque.names}
    if not used:
        return {}
    bare, at = rigid_model(model.unpushed), shape_values(model, shapes)
    own = np.array([at[entry.name] for entry in bare.shapes])
    rigid = np.zeros(len(bare.parameters))
    rigid[rigid_places(bare)] = linear[rigid_places(model)]
    found: dict[str, Float] = {}
    numbers = range(1, len(model.joints) + 1)
    for number in numbers:
        for field, state in zip(_FIELDS, STATES, strict=True):
            words = [f"tau{i}_by_{state}{number}" for i in numbers]
            if used & {*words}:
                found |= dict(zip(words, _slope(bare, motion, field, number - 1, rigid, own), strict=True))
    return found


def _slope(bare: ModelStructure, motion: Motion, field: str, joint: int, rigid: Float, own: Float) -> Float:
    """Return the derivative (J, N) of the torque of `bare` with the numbers `rigid` by an angle, velocity or
    acceleration of a joint.

    Being linear in the numbers, it is derived once for a motion where the mechanism has none of its own; kept are the
    columns that are not zero, since a link's numbers show at few joints and the angles beyond it change nothing.
    """
    if bare.derived or len(motion) > LONGEST_KEPT:
        return _difference(motion, field, joint, lambda moved: model_torque(bare, moved, rigid, own)).T
    kept = _DERIVED.setdefault(motion, {})
    key = field, joint, bare.thigh_length, bare.pull, bare.chain, bare.moving_base
    shape = len(motion), motion.q.shape[1], bare.base_count
    if key not in kept:
        columns, none = compiled(bare).pointwise, np.zeros(bare.base_count)
        whole = _difference(motion, field, joint, lambda moved: np.swapaxes(columns(moved, none, own), 0, 1))
        flat = whole.reshape(len(motion), -1)
        live = np.flatnonzero(flat.any(axis=0))
        kept[key] = live, flat[:, live]
    live, values = kept[key]
    flat = np.zeros((len(motion), shape[1] * shape[2]))
    flat[:, live] = values
    return np.asarray(flat.reshape(shape).swapaxes(0, 1) @ rigid)


def _difference(motion: Motion, field: str, joint: int, of: Callable[[Motion], Float]) -> Float:
    """Return the derivative (N, ...) of what `of` gives for motions (N, ...) by an angle, velocity or acceleration of a
    joint; each two motions are evaluated as one.
    """
    own, values, count = np.eye(motion.q.shape[1])[joint], getattr(motion, field), len(motion)
    twice = {name: np.concatenate([getattr(motion, name)] * 2) for name in ("t", "q", "dq", "ddq", "sign")}
    base = None if motion.base is None else np.concatenate([motion.base] * 2)
    parts = []
    for step, weight in STENCIL[field]:
        moved = Motion(**{**twice, field: np.concatenate([values + step * own, values - step * own])}, base=base)
        found = of(moved)
        parts.append(weight * (found[:count] - found[count:]))
    return np.asarray(sum(parts))


_FIELDS = ("q", "dq", "ddq")
STENCIL = {
    "q": ((0.01, 75.0), (0.02, -15.0), (0.03, 5.0 / 3.0)),
    "dq": ((1.0, 0.5),),
    "ddq": ((1.0, 0.5),),
}
"""(step, weight) of the differences f(x + step) - f(x - step) that make a derivative: of sixth order by an angle; exact
by a velocity and an acceleration, in which the torque is quadratic and linear."""
_DERIVED: WeakKeyDictionary[Motion, dict[tuple[Any, ...], tuple[np.ndarray, Float]]] = WeakKeyDictionary()
"""Derivatives of the base columns along motions that are still in use, where they are not zero: places (L,) among
(J, P), and values (N, L). Computed anew each time, `diagnose` on an arm of six joints takes 74 instead of 30 s; with
the zeros they were half of all memory on one.
"""


def transformed(model: ModelStructure, term: Term, motion: Motion, linear: Float, shapes: Float, nodes: Float) -> Float:
    """Return the torque (V, J, N) that a transform adds to that of `model`, at V rows of the transform's own shapes
    `nodes` (V, S); other arguments as of `model_torque`.
    """
    carried = carrying(model, motion, linear)
    torque = _untransformed(model, motion, shapes, carried) @ carried
    words = motion_words(motion) | {f"tau_model{j + 1}": values for j, values in enumerate(torque)}
    words |= {key: nodes[:, [k]] for k, key in enumerate(term.effect.shape)}
    out = np.zeros((len(nodes), len(model.joints), len(motion)))
    for text in torques(term):
        out[:, text.joint] += torque_values(text, words, motion, count=len(nodes))
    return out


def derived_columns(model: ModelStructure, motion: Motion, shapes: Float, reference: Float) -> Callable[[Float], Float]:
    """Return a function that gives the columns (V, J, m, N) of the model's last effect alone, one that changes the
    mechanism, at V rows of shapes (V, S), any of `shapes`, before late or filtered sensors; other arguments as of
    `columns`.
    """
    term = model.terms[-1]
    count = len(term.effect.coefficients)
    bare = rigid_model(model.unpushed)  # no number that changes the mechanism moves the place of a measured force
    names = [entry.name for entry in model.shapes]
    own = [names.index(entry.name) for entry in bare.shapes]
    outside = range(model.friction.stop, model.base_count)
    chosen = [k for k in base_places(model) if k not in outside and k < len(model.parameters)]
    linear = carrying(model, motion, reference)[chosen]

    def computed(some: Float) -> Float:
        return compiled(bare).columns_at(motion, linear, some[:, own], len(chosen) - count)

    still = [names.index(f"{term.name}.{key}") for key, entry in term.effect.shape.items() if entry.turns]
    unturned = {key: entry for key, entry in term.effect.shape.items() if not entry.turns}
    swings = [entry.unit for entry in unturned.values()] == ["Hz"] and not shapes[:, still].any()
    if len(shapes) < FEW or count % 2 or not swings:
        return computed
    place = names.index(f"{term.name}.{next(iter(unturned))}")
    few = shapes[[0, len(shapes) // 2, -1]]
    known = computed(few)
    phase = 2.0 * np.pi * motion.t
    first, carried = few[0, place] * phase, np.swapaxes(known[0], 0, 1)
    carried = np.sin(first) * carried[0::2] + np.cos(first) * carried[1::2]
    waves = Waves(carried, phase, place)
    rounding = SAME * np.abs(known).max() * (1.0 + np.ptp(motion.t) * np.abs(few[:, place]).max())
    return waves if np.abs(waves(few) - known).max() <= rounding else computed


SAME = 1e-12
"""Rounding of a column, of its size, for each turn of the phase."""


_KEPT: WeakKeyDictionary[Motion, tuple[tuple[Any, ...], Float]] = WeakKeyDictionary()
"""Base columns of the plain machine along motions that are still in use, with its lengths, gravity and forces. Computed
anew each time they take 0.5 to 0.8 s of the 5 s of `discover` on a leg, and 9 of the 39 s of `diagnose` on an arm.
"""
LONGEST_KEPT = 400_000
"""Samples of a motion whose base columns are kept, at most: 50 MB."""


def _base_columns(model: ModelStructure, motion: Motion, linear: Float, at: Mapping[str, float]) -> Float:
    """Return the columns (J, N, B) of mechanism and friction, those at `base_places`; not to be written to."""
    if not model.derived and len(motion) <= LONGEST_KEPT:
        # A search asks for the same motion thousands of times, each time with another effect.
        size = model.thigh_length, model.pull, model.chain, model.moving_base, model.forces
        kept = _KEPT.get(motion)
        if kept is None or kept[0] != size:
            count = np.zeros(model.base_count)
            kept = _KEPT[motion] = size, compiled(model.base()).pointwise(motion, count, np.zeros(0))
        return kept[1]
    bare, chosen = rigid_model(model), base_places(model)
    shapes = np.array([at[name] for name in (s.name for s in bare.shapes)])
    return compiled(bare).pointwise(motion, linear[chosen[: len(bare.parameters)]], shapes)


def _add(term: Term, env: dict[str, Float | float], motion: Motion, out: Float, place: dict[str, int]) -> None:
    """Write the columns of an ordinary text into `out`."""
    keys, kept = tuple(term.effect.coefficients), dict[Any, Any]()
    for torque in torques(term):
        for key in keys:
            if key in torque.names:
                out[torque.joint, :, place[f"{term.name}.{key}"]] = torque_values(
                    part_of(torque, key, keys), env, motion, kept=kept
                )
