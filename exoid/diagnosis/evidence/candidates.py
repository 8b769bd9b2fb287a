"""Every catalogue entry as columns for these recordings: what the data would have to look like if it were missing.

An entry with linear coefficients gives one column per coefficient, for every trial value (node) of its shape
parameters. An entry without (a tilt, an encoder offset) gives the *tangent*: how the model's torque would change with
it, at the present parameters; where its number belongs to the recording (a delay), it gives the change itself at every
trial value. Nothing here ever looks at the measured torque.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.ground.errors import ExpressionError
from exoid.measurement.signals.butterworth import WaveProducts
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.symbolic.columns import derived_columns, slopes_of, transformed
from exoid.symbolic.evaluation import apply_transforms, carrying, fed_back, motion_words, torque_values
from exoid.symbolic.language.deflection import SLOPES
from exoid.symbolic.language.lower import to_numpy
from exoid.symbolic.language.torque import Torque, is_transform, part_of, torques, transforms
from exoid.symbolic.language.tree import Binary, Call, Name
from exoid.symbolic.language.words import FEEDBACK
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float, Motion
from exoid.symbolic.term import Term
from exoid.symbolic.waves import Waves

TANGENT_STEP = 1e-3
"""Step of a tangent, as a share of the range of the number."""
TOGETHER = 150_000
"""Values that are computed and filtered at once: more no longer fit into a processor's cache."""
AT_ONCE = 32
"""Nodes of late columns that are computed at once."""


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
    def reads_torque(self) -> bool:
        """True if it is no effect, but another reading of a torque."""
        return self.change and self.term.effect.family == "reading"

    @property
    def change(self) -> bool:
        """True if its single column is the change of the model's torque at a value of its number."""
        return not self.tangent and not self.term.effect.coefficients

    @property
    def joints(self) -> tuple[int, ...]:
        """Indices of the joints whose torque it changes."""
        return self.term.reaches

    @property
    def numbers(self) -> int:
        """Count of the numbers that it adds to the model."""
        return len(self.term.effect.coefficients) + len(self.term.effect.shape)

    @property
    def width(self) -> int:
        """Number of its columns at each of its joints."""
        return max(1, len(self.term.effect.coefficients))

    @cached_property
    def common(self) -> np.ndarray:
        """Indices of the nodes that are the same in every recording, each once."""
        same = np.flatnonzero(np.all(self.nodes == self.nodes[:1], axis=(0, 2)))
        return same[np.sort(np.unique(self.nodes[0, same], axis=0, return_index=True)[1])]

    @property
    def at_one_place(self) -> Candidate:
        """The candidate with the nodes alone that are the same in every recording."""
        return replace(self, nodes=self.nodes[:, self.common])

    @property
    def per_recording(self) -> tuple[int, ...]:
        """Indices of the shape parameters that each recording has to itself."""
        return tuple(i for i, s in enumerate(self.term.effect.shape.values()) if s.per_recording)

    @cached_property
    def groups(self) -> list[np.ndarray]:
        """Nodes that differ between recordings, those together that share every other value."""
        moving = np.setdiff1d(np.arange(self.nodes.shape[1]), self.common)
        if not self.per_recording or not moving.size:
            return []
        _, label = np.unique(np.delete(self.nodes[0, moving], self.per_recording, axis=1), axis=0, return_inverse=True)
        return [moving[label.ravel() == k] for k in range(label.max() + 1)]


def feeds_back(term: Term) -> bool:
    """True if the columns of a term follow the model's own torque."""
    if term.effect.derive is not None:
        return True
    return any(torque.names & FEEDBACK for torque in torques(term))


class LateColumns(Columns):
    """Columns of a candidate on one recording at `nodes` (V, S), so many that some of them are computed when they are
    asked for: memory for all takes longer to get than they take to be computed.
    """

    def __init__(self, candidate: Candidate, nodes: Float, one: PreparedRecording, fitted: FittedModel) -> None:
        vars(self).update(joints=candidate.joints, candidate=candidate, nodes=nodes, recording=one, fitted=fitted)

    candidate: Candidate
    nodes: Float
    recording: PreparedRecording
    fitted: FittedModel

    @cached_property
    def _unfiltered(self) -> Callable[[Float], Float]:
        return _unfiltered_columns(self.candidate, self.nodes, self.recording, self.fitted)

    def _at(self, nodes: Float) -> Float:
        """Return the filtered columns (V, A, K, m) at some nodes."""
        shape = len(nodes), self.candidate.width, len(self.joints)
        values = np.empty((*shape, len(self.recording.kept)))
        parts = -(-math.prod(shape) * len(self.recording.motion) // TOGETHER)
        for some in np.array_split(np.arange(len(nodes)), min(len(nodes), parts)):
            raw = np.ascontiguousarray(np.swapaxes(self._unfiltered(nodes[some]), 1, 2))
            self.recording.smooth_rows(raw, self.joints, 2, values[some[0] : some[-1] + 1])
        return np.moveaxis(values, 1, 3)

    @property
    def values(self) -> Float:
        """The columns of all nodes."""
        return self._at(self.nodes)

    @property
    def pieces(self) -> list[slice]:
        """The nodes in pieces that are worth having at once."""
        return [slice(at, at + AT_ONCE) for at in range(0, len(self.nodes), AT_ONCE)]

    @property
    def is_absent(self) -> bool:
        """True if it is known not to act on this recording."""
        return False

    def some(self, nodes: slice | np.ndarray) -> Columns:
        """Return the columns of some nodes; of all of them, these."""
        if isinstance(nodes, slice) and nodes == slice(None):
            return self
        return Columns(self.joints, self._at(self.nodes[nodes]))

    def sums(self, weights: Float, signals: Float) -> WaveProducts | None:
        """Return the sums of products of the columns at all nodes with weights (U, A, K) and weighted signals (S, A, K,
        Q) where these are to be had without the columns; None elsewhere.
        """
        waves = self._unfiltered
        if not isinstance(waves, Waves):
            return None
        return self.recording.wave_products(waves, self.nodes, self.joints, weights, signals)

    def products(self, weights: Float, signals: Float) -> tuple[Float, Float]:
        """Return the products, as for any columns."""
        if (found := self.sums(weights[None], signals[None])) is not None:
            return found.both[0], found.square[0]
        parts = [self.some(piece).products(weights, signals) for piece in self.pieces]
        both, square = (np.concatenate(each) for each in zip(*parts, strict=True))
        return both, square


def candidate_columns(candidate: Candidate, nodes: Float, one: PreparedRecording, fitted: FittedModel) -> Columns:
    """Return the filtered columns of a candidate on one recording at `nodes` (V, S)."""
    return Columns(candidate.joints, LateColumns(candidate, nodes, one, fitted).values)


def _unfiltered_columns(
    candidate: Candidate, nodes: Float, one: PreparedRecording, fitted: FittedModel
) -> Callable[[Float], Float]:
    """Function that gives the columns (V, A, m, N) of a candidate at some of its `nodes`, on all samples of a
    recording, as `candidate_columns` filters them.
    """
    if candidate.tangent:
        return lambda some: _tangent(candidate.term, one, fitted)[None]
    if candidate.change:
        return partial(_changes, candidate.term, one, fitted)
    derived = candidate.term.effect.derive is not None
    own = _derived(candidate.term, one, fitted, nodes) if derived else _texts(candidate, one, fitted)
    return partial(_as_measured, candidate, one, fitted, own) if transforms(fitted.model.terms) else own


def _as_measured(
    candidate: Candidate, one: PreparedRecording, fitted: FittedModel, columns: Callable[[Float], Float], nodes: Float
) -> Float:
    """Return `columns` (V, A, m, N) as the late or filtered sensors of the model show them."""
    found = columns(nodes)
    count, _, many, samples = found.shape
    out = np.zeros((len(fitted.model.joints), samples, count * many))
    out[list(candidate.joints)] = found.transpose(1, 3, 0, 2).reshape(len(candidate.joints), samples, -1)
    apply_transforms(fitted.model, out, fitted.shape, one.motion)
    seen = out[list(candidate.joints)].reshape(len(candidate.joints), samples, count, many)
    return np.ascontiguousarray(seen.transpose(2, 0, 3, 1))


def _texts(candidate: Candidate, one: PreparedRecording, fitted: FittedModel) -> Callable[[Float], Float]:
    term, motion = candidate.term, one.motion
    keys, shape_keys = tuple(term.effect.coefficients), tuple(term.effect.shape)
    words = motion_words(motion)
    if feeds_back(term):
        known = own_torques(fitted, one)
        if not known.keys() >= {name for torque in torques(term) for name in torque.names & SLOPES}:
            carried = carrying(fitted.model, motion, fitted.linear)
            known |= slopes_of(fitted.model, (term,), motion, carried, fitted.shape)
        words |= known
    if (waves := _waves(term, words, len(motion))) is not None:
        return waves

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


def _waves(term: Term, words: dict[str, Float | float], samples: int) -> Waves | None:
    """Return the columns of a term at one joint that is a sin(n x) + b cos(n x), n its only shape; None of others."""
    keys, texts = tuple(term.effect.coefficients), torques(term)
    if len(texts) != 1 or len(keys) != 2 or len(term.effect.shape) != 1:
        return None
    parts = [part_of(texts[0], key, keys).node for key in keys]
    (number,) = term.effect.shape
    match parts:
        case [Call("sin", (Binary("*", Name(first), x),)), Call("cos", (Binary("*", Name(second), y),))]:
            if first == second == number and x == y and number not in x.names():
                phase = np.broadcast_to(to_numpy(x, words), (samples,))
                return Waves(np.ones((1, 1, samples)), np.ascontiguousarray(phase))
    return None


def _at_nodes(
    torque: Torque,
    words: dict[str, Float | float],
    keys: tuple[str, ...],
    nodes: Float,
    motion: Motion,
    kept: dict[Any, Any] | None = None,
) -> Float:
    """Return a torque (V, N) at every node, NaN where it is not finite; `kept` as of `to_numpy`, of the same nodes."""
    shaped = {key: nodes[:, [i]] for i, key in enumerate(keys)}
    try:
        return torque_values(torque, {**words, **shaped}, motion, len(nodes), kept)
    except ExpressionError:  # at some node: find out which
        if len(nodes) == 1:
            return np.full((1, len(motion)), np.nan)
        return np.concatenate([_at_nodes(torque, words, keys, node[None], motion) for node in nodes])


_FED_BACK: WeakKeyDictionary[FittedModel, WeakKeyDictionary[PreparedRecording, dict[str, Float]]] = WeakKeyDictionary()
"""Torques of the model that is asked about, and their slopes: several candidates are made of the same ones."""


def own_torques(fitted: FittedModel, one: PreparedRecording) -> dict[str, Float]:
    """Return tau_rigid and tau_model (N,) of all joints, from the parameters of the model (never measured), and from
    what is carried.
    """
    if fitted not in _FED_BACK:
        _FED_BACK.clear()
    kept = _FED_BACK.setdefault(fitted, WeakKeyDictionary()).setdefault(one, {})
    if not kept:
        base = fitted.model.base()
        numbers = carrying(base, one.motion, fitted.linear[: len(base.parameters)])
        # All at once: the page answers by several threads, and another may ask meanwhile.
        kept |= fed_back(base, base.whole_columns(one.motion), numbers, one.motion)
    return kept


@lru_cache(maxsize=256)
def _extended(model: Model, term: Term) -> Model:
    return model.with_effect(term.effect, term.joint)


def _tangent(term: Term, one: PreparedRecording, fitted: FittedModel) -> Float:
    """Return ∂τ/∂(the term's number) (A, 1, N) at zero, from a small value of it to either side."""
    first, *rest = term.placed_shape.values()
    step = TANGENT_STEP * (first.max - first.min)
    typical = [s.typical or 0.5 * (s.min + s.max) for s in rest]
    above, below = _changes(term, one, fitted, np.array([[step, *typical], [-step, *typical]]))
    return (above - below) / (2.0 * step)


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
    """Function that gives the new columns (V, A, m, N) of a changed mechanism at some of `nodes` (V, S)."""
    extended = _extended(fitted.model, term)
    new = len(extended.parameters) - len(fitted.model.parameters)
    reference = np.concatenate([fitted.linear, np.zeros(new)])

    def shapes(some: Float) -> Float:
        return np.column_stack([np.tile(fitted.shape, (len(some), 1)), some])

    columns, joints = derived_columns(extended, one.motion, shapes(nodes), reference), list(term.reaches)
    if isinstance(columns, Waves):
        return Waves(columns.carried[:, joints], columns.phase, columns.place - len(fitted.shape))
    if joints == list(range(len(extended.joints))):
        return lambda some: columns(shapes(some))
    return lambda some: columns(shapes(some))[:, joints]
