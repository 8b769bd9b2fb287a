"""Every catalogue entry as columns for these recordings: what the data would have to look like if it were missing.

An entry with linear coefficients gives one column per coefficient, for every trial value (node) of its shape
parameters. An entry without (a tilt, an encoder offset) gives the *tangent*: how the model's torque would change with
it, at the present parameters; where its number belongs to the recording (a delay), it gives the change itself at every
trial value. Nothing here ever looks at the measured torque.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from diagnosis.evidence.columns import Columns
from diagnosis.evidence.fitted import FittedModel
from ground.engines.workers import shared
from ground.errors import ExpressionError
from optimisation.fitting.shapes import from_unit
from optimisation.preparation.filtering import PreparedRecording
from optimisation.preparation.prepare import Prepared
from symbolic.catalogue import catalogue
from symbolic.columns import derived_columns, slopes_of, transformed
from symbolic.effect import Effect, Shape
from symbolic.evaluation import carrying, motion_words, torque_values
from symbolic.language.deflection import SLOPES
from symbolic.language.torque import Torque, is_transform, part_of, torques
from symbolic.language.words import FEEDBACK
from symbolic.model import Model
from symbolic.motion import Float, Motion
from symbolic.term import Term, places_of

TANGENT_STEP = 1e-3
"""Step of a tangent, as a share of the range of the number."""
FINE = 50
"""Nodes from which on columns that depend on the model's numbers are not computed at every step."""
QUANTILES = (0.3, 0.5, 0.6, 0.7, 0.78, 0.85, 0.9, 0.93, 0.95, 0.97, 0.98, 0.99, 0.995)
"""Where on a joint's path a position is tried (and mirrored for the other end)."""
TOGETHER = 150_000
"""Values that are computed and filtered at once: more no longer fit into a processor's cache."""
MOMENTS = (1.12, 1.25, 1.4, 1.6, 1.85, 2.15, 2.6, 3.2, 4.2, 6.0, 10.0)
"""Moments after the end of a recording that are tried, in its lengths (and mirrored, before its beginning)."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """A term that the model does not have, with the nodes (R, V, S) of its shape parameters in every recording.

    The rows R differ only where a value belongs to the recording: node v is then the same *place on the path*.

    `tangent`: its single column is the derivative by its only number, which is a shape parameter.
    """

    term: Term
    nodes: Float
    tangent: bool

    @property
    def name(self) -> str:
        """Full name, e.g. "stribeck:knee"."""
        return self.term.name

    @property
    def change(self) -> bool:
        """Whether its single column is the change of the model's torque at a value of its number."""
        return not self.tangent and not self.term.effect.coefficients

    @property
    def joints(self) -> tuple[int, ...]:
        """Indices of the joints whose torque it changes."""
        return self.term.reaches

    @property
    def numbers(self) -> int:
        """How many numbers it adds to the model."""
        return len(self.term.effect.coefficients) + len(self.term.effect.shape)

    @property
    def width(self) -> int:
        """How many columns it has at each of its joints."""
        return max(1, len(self.term.effect.coefficients))

    @property
    def common(self) -> np.ndarray:
        """Indices of the nodes that are the same in every recording, each once."""
        same = np.flatnonzero(np.all(self.nodes == self.nodes[:1], axis=(0, 2)))
        return same[np.sort(np.unique(self.nodes[0, same], axis=0, return_index=True)[1])]

    @property
    def per_recording(self) -> tuple[int, ...]:
        """Indices of the shape parameters that each recording has to itself."""
        return tuple(i for i, s in enumerate(self.term.effect.shape.values()) if s.per_recording)


@dataclass(frozen=True, eq=False)
class Library:
    """The candidates for a question, and their columns; those that no parameter can change are kept, the others for as
    long as the same model is asked about.
    """

    entries: tuple[Candidate, ...]
    _own: dict[str, Candidate] = field(default_factory=dict)
    _kept: dict[str, tuple[Columns, ...]] = field(default_factory=dict)
    _beside: WeakKeyDictionary[FittedModel, dict[str, tuple[Columns, ...]]] = field(default_factory=WeakKeyDictionary)

    @property
    def candidates(self) -> tuple[Candidate, ...]:
        """The candidates, in the order of the catalogue."""
        return tuple(self._own.get(one.name, one) for one in self.entries)

    def narrow(self, name: str, nodes: Float) -> None:
        """From now on let the candidate called `name` have these nodes (R, V, S) alone."""
        self._own[name] = replace(self.find(name), nodes=nodes)
        for kept in (self._kept, *self._beside.values()):
            kept.pop(name, None)

    def find(self, name: str) -> Candidate:
        """Return the candidate called `name` with all its nodes."""
        return next(c for c in self.candidates if c.name == name)

    def columns(self, candidate: Candidate, fitted: FittedModel) -> tuple[Columns, ...]:
        """Return the columns of `candidate` on every recording, beside the model `fitted` at its numbers.

        Those of a finely searched candidate stay as they were first: other numbers only scale them, and they are
        computed anew where it is compared (`look_alikes.refine`).
        """
        if candidate.name in (beside := self._beside.get(fitted, {})):
            return beside[candidate.name]
        room = self.room(candidate, fitted.prepared)
        self.fill(candidate, fitted, room)
        return self.keep(candidate, fitted, room)

    def room(self, candidate: Candidate, prepared: Prepared) -> tuple[Columns, ...]:
        """Return the columns that are kept of `candidate`, or room for them which copies of this process see."""
        if candidate.name in self._kept:
            return self._kept[candidate.name]
        own = candidate.nodes.shape[1], candidate.width, len(candidate.joints)
        shapes = [(*own, len(one.kept)) for one in prepared.all]
        sizes = [int(np.prod(shape)) for shape in shapes]
        values = np.frombuffer(shared(sum(sizes)), dtype=float)
        parts = np.split(values[: sum(sizes)], np.cumsum(sizes)[:-1])
        return tuple(
            Columns(candidate.joints, np.moveaxis(part.reshape(shape), 1, 3))
            for part, shape in zip(parts, shapes, strict=True)
        )

    def fill(self, candidate: Candidate, fitted: FittedModel, room: tuple[Columns, ...]) -> None:
        """Compute the columns of `candidate` into the `room` for them, unless they are kept."""
        if candidate.name not in self._kept:
            for nodes, one, columns in zip(candidate.nodes, fitted.prepared.all, room, strict=True):
                _fill(candidate, nodes, one, fitted, columns)

    def keep(self, candidate: Candidate, fitted: FittedModel, columns: tuple[Columns, ...]) -> tuple[Columns, ...]:
        """Keep the columns of `candidate` beside `fitted`, beside any model if no parameter can change them; and return
        them.
        """
        fine = candidate.nodes.shape[1] > FINE
        if not candidate.tangent and (fine or not _feeds_back(candidate.term)):
            self._kept[candidate.name] = columns
            return columns
        if fitted not in self._beside:
            self._beside.clear()
        self._beside.setdefault(fitted, {})[candidate.name] = columns
        return columns


def build_library(model: Model, prepared: Sequence[PreparedRecording], extra: Iterable[Effect] = ()) -> Library:
    """Return every effect of the catalogue, and the user's `extra` ones, at every joint where it exists.

    Terms that `model` already has are left out, and effects of a drive, or of the model's own torque, at a joint that
    has no drive in any recording.
    """
    driven = [any(one.driven[j] for one in prepared) for j in range(len(model.joints))]
    known = {term.name for term in model.terms}
    found = []
    for effect in (*catalogue(model.joints).values(), *extra):
        for joint in places_of(effect, model.joints):
            term = Term(effect, joint, model.joints)
            # Of a joint whose torque is always zero, the model's own torque is its residual: it would explain itself.
            undriven = joint is not None and not driven[term.first]
            idle = undriven and (effect.drive or (effect.derive is None and _feeds_back(term)))
            if term.name not in known and not idle:
                own = any(shape.per_recording for shape in effect.shape.values())
                tangent = not effect.coefficients and not own
                found.append(Candidate(term, _nodes(term, prepared, tangent), tangent))
    return Library(tuple(found))


def _nodes(term: Term, prepared: Sequence[PreparedRecording], tangent: bool) -> Float:
    shapes = list(term.placed_shape.values())
    if tangent or not shapes:
        return np.zeros((len(prepared), 1, len(shapes)))
    if not any(shape.per_recording and not shape.turns for shape in shapes):
        return _product(shapes, term, [prepared] * len(prepared))
    # Each recording at its own place, and all of them at the same one: where a recording hardly shows it, its own path
    # says little about where.
    own = _product(shapes, term, [[one] for one in prepared])
    return np.concatenate([own, _product(shapes, term, [prepared] * len(prepared))], axis=1)


def _product(shapes: Sequence[Shape], term: Term, paths: Sequence[Sequence[PreparedRecording]]) -> Float:
    return np.array([list(itertools.product(*(_axis(s, term, path) for s in shapes))) for path in paths], dtype=float)


def _axis(shape: Shape, term: Term, paths: Sequence[PreparedRecording]) -> Sequence[float]:
    if shape.choices:
        return shape.choices
    if shape.turns:  # another one for all recordings is other coefficients
        return (0.0,)
    if shape.spacing == "position" and term.joint is not None:
        joint = term.first
        levels = sorted({*QUANTILES, *(round(1.0 - u, 6) for u in QUANTILES)})
        places = np.quantile(np.concatenate([p.motion.q[:, joint] for p in paths]), levels)
        return tuple(np.clip(places, shape.min, shape.max))
    if shape.spacing == "time":
        begin = min(float(p.motion.t[0]) for p in paths)
        lasts = max(float(p.motion.t[-1]) for p in paths) - begin
        far = [*MOMENTS, *(1.0 - moment for moment in MOMENTS)]
        return tuple(np.clip([begin + u * lasts for u in (*np.linspace(0.0, 1.0, 11), *far)], shape.min, shape.max))
    return tuple(from_unit(shape, u) for u in np.linspace(0.0, 1.0, max(2, shape.points)))


def _feeds_back(term: Term) -> bool:
    if term.effect.derive is not None:
        return True
    return any(torque.names & FEEDBACK for torque in torques(term))


def candidate_columns(candidate: Candidate, nodes: Float, one: PreparedRecording, fitted: FittedModel) -> Columns:
    """Return the filtered columns of a candidate on one recording at `nodes` (V, S)."""
    shape = len(nodes), candidate.width, len(candidate.joints), len(one.kept)
    columns = Columns(candidate.joints, np.moveaxis(np.empty(shape), 1, 3))
    _fill(candidate, nodes, one, fitted, columns)
    return columns


def _fill(candidate: Candidate, nodes: Float, one: PreparedRecording, fitted: FittedModel, into: Columns) -> None:
    """Write the filtered columns of a candidate on one recording at `nodes` (V, S)."""
    values = np.moveaxis(into.values, 3, 1)  # (V, m, A, K): as the evidence reads it
    parts = -(-len(nodes) * candidate.width * len(candidate.joints) * len(one.motion) // TOGETHER)
    unfiltered = unfiltered_columns(candidate, nodes, one, fitted)
    for some in np.array_split(np.arange(len(nodes)), min(len(nodes), parts)):
        raw = np.ascontiguousarray(np.swapaxes(unfiltered(nodes[some]), 1, 2))
        one.smooth_rows(raw, candidate.joints, 2, values[some[0] : some[-1] + 1])


def unfiltered_columns(
    candidate: Candidate, nodes: Float, one: PreparedRecording, fitted: FittedModel
) -> Callable[[Float], Float]:
    """Return what gives the columns (V, A, m, N) of a candidate at some of its `nodes`, on all samples of a recording,
    as `candidate_columns` filters them.
    """
    if candidate.tangent:
        return lambda some: _tangent(candidate.term, one, fitted)[None]
    if candidate.change:
        return partial(_changes, candidate.term, one, fitted)
    if candidate.term.effect.derive is not None:
        return _derived(candidate.term, one, fitted, nodes)
    return _texts(candidate, one, fitted)


def _texts(candidate: Candidate, one: PreparedRecording, fitted: FittedModel) -> Callable[[Float], Float]:
    term, motion = candidate.term, one.motion
    keys, shape_keys = tuple(term.effect.coefficients), tuple(term.effect.shape)
    words = motion_words(motion)
    if _feeds_back(term):
        words |= fed_back((term,), one, fitted)

    def at(nodes: Float) -> Float:
        out, kept = np.zeros((len(nodes), len(candidate.joints), len(keys), len(motion))), dict[Any, Any]()
        for torque in torques(term):
            place = candidate.joints.index(torque.joint)
            for m, key in enumerate(keys):
                if key in torque.names:
                    out[:, place, m] = _at_nodes(part_of(torque, key, keys), words, shape_keys, nodes, motion, kept)
        kept.clear()  # what evaluates a text refers to itself: these would stay until garbage is collected
        if np.isnan(out.sum()):  # zero, so that such a node is never chosen
            out[np.isnan(out).any(axis=(1, 2, 3))] = 0.0
        return out

    return at


def _at_nodes(
    torque: Torque,
    words: dict[str, Float | float],
    keys: tuple[str, ...],
    nodes: Float,
    motion: Motion,
    kept: dict[Any, Any],
) -> Float:
    """Return a torque (V, N) at every node, NaN where it is not finite; `kept` as of `to_numpy`, of the same nodes."""
    shaped = {key: nodes[:, [i]] for i, key in enumerate(keys)}
    try:
        return torque_values(torque, {**words, **shaped}, motion, len(nodes), kept)
    except ExpressionError:  # at some node: find out which
        return np.stack([_at_node(torque, words, keys, node, motion) for node in nodes])


def _at_node(
    torque: Torque, words: dict[str, Float | float], keys: tuple[str, ...], node: Float, motion: Motion
) -> Float:
    try:
        return torque_values(torque, {**words, **dict(zip(keys, map(float, node), strict=True))}, motion)
    except ExpressionError:
        return np.full(len(motion), np.nan)


_FED_BACK: WeakKeyDictionary[FittedModel, WeakKeyDictionary[PreparedRecording, dict[str, Float]]] = WeakKeyDictionary()
"""Torques of models that are still in use, and their slopes: several candidates are made of the same ones."""


def fed_back(terms: Sequence[Term], one: PreparedRecording, fitted: FittedModel) -> dict[str, Float]:
    """Return the words for the model's own torque and its slopes that the texts of `terms` speak of, and others."""
    kept = own_torques(fitted, one)
    if not kept.keys() >= {name for term in terms for torque in torques(term) for name in torque.names & SLOPES}:
        kept |= slopes_of(fitted.model, terms, one.motion, carrying(one.motion, fitted.linear), fitted.shape)
    return kept


def own_torques(fitted: FittedModel, one: PreparedRecording) -> dict[str, Float]:
    """Return tau_rigid and tau_model (N,) of all joints, from the parameters of the model (never measured)."""
    kept = _FED_BACK.setdefault(fitted, WeakKeyDictionary()).setdefault(one, {})
    if not kept:
        base = fitted.model.base()
        count, rigid = len(base.parameters), len(base.inertial)
        columns, numbers = base.columns(one.motion), carrying(one.motion, fitted.linear[:count])
        for j in range(len(columns)):
            kept[f"tau_rigid{j + 1}"] = columns[j][:, :rigid] @ numbers[:rigid]
            kept[f"tau_model{j + 1}"] = columns[j] @ numbers
    return kept


@lru_cache(maxsize=256)
def _extended(model: Model, term: Term) -> Model:
    return model.with_effect(term.effect, term.joint)


def _tangent(term: Term, one: PreparedRecording, fitted: FittedModel) -> Float:
    """Return ∂τ/∂(the term's number) (A, 1, N) at zero, from a small value of it to either side."""
    nodes, width = tangent_nodes(term)
    changes = _changes(term, one, fitted, nodes)
    return (changes[0] - changes[1]) / width


def tangent_nodes(term: Term) -> tuple[Float, float]:
    """Return the two nodes (2, S) of a tangent, above and below zero, and how far apart they are."""
    first, *rest = term.placed_shape.values()
    step = TANGENT_STEP * (first.max - first.min)
    typical = [s.typical or 0.5 * (s.min + s.max) for s in rest]
    return np.array([[step, *typical], [-step, *typical]]), 2.0 * step


def _changes(term: Term, one: PreparedRecording, fitted: FittedModel, nodes: Float) -> Float:
    """Return by how much the term changes the model's torque (V, A, 1, N) at `nodes` (V, S) of its numbers."""
    joints = list(term.reaches)
    different, back = np.unique(nodes, axis=0, return_inverse=True)
    if is_transform(term):
        changes = transformed(fitted.model, term, one.motion, fitted.linear, fitted.shape, different)[:, joints]
    else:
        extended = _extended(fitted.model, term)
        still = fitted.model.torque(one.motion, fitted.linear, fitted.shape)
        found = [extended.torque(one.motion, fitted.linear, np.concatenate([fitted.shape, node])) for node in different]
        changes = np.stack([(torque - still).T[joints] for torque in found])
    return changes[back.ravel()][:, :, None]


def _derived(term: Term, one: PreparedRecording, fitted: FittedModel, nodes: Float) -> Callable[[Float], Float]:
    """Return what gives the new columns (V, A, m, N) of a changed mechanism at some of `nodes` (V, S) of its shapes."""
    extended = _extended(fitted.model, term)
    new = len(extended.parameters) - len(fitted.model.parameters)
    reference = np.concatenate([fitted.linear, np.zeros(new)])

    def shapes(some: Float) -> Float:
        return np.column_stack([np.tile(fitted.shape, (len(some), 1)), some])

    columns, joints = derived_columns(extended, one.motion, shapes(nodes), reference), list(term.reaches)
    if joints == list(range(len(extended.joints))):
        return lambda some: columns(shapes(some))
    return lambda some: columns(shapes(some))[:, joints]
