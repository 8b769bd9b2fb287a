"""The candidates for a question, and their columns, which are kept as long as they stay what they are."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from weakref import WeakKeyDictionary

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate, LateColumns, candidate_columns, feeds_back
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.optimisation.fitting.shapes import from_unit
from exoid.optimisation.preparation.filtering import PreparedRecording, driven_joints
from exoid.symbolic.effect import Effect, Shape
from exoid.symbolic.effect_catalogue import catalogue
from exoid.symbolic.language.torque import transforms
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float
from exoid.symbolic.term import Term, places_of

FINE = 50
"""Nodes from which on columns that depend on the model's numbers are not computed at every step."""
QUANTILES = (0.3, 0.5, 0.6, 0.7, 0.78, 0.85, 0.9, 0.93, 0.95, 0.97, 0.98, 0.99, 0.995)
"""Where on a joint's path a position is tried (and mirrored for the other end)."""
MANY = 250
"""Columns of a candidate on a recording beyond which they are not kept."""
MOMENTS = (1.12, 1.25, 1.4, 1.6, 1.85, 2.15, 2.6, 3.2, 4.2, 6.0, 10.0)
"""Moments after the end of a recording that are tried, in its lengths (and mirrored, before its beginning)."""


@dataclass(eq=False)
class Library:
    """The candidates for a question, in the order of the catalogue, and their columns; those that no parameter can
    change are kept, the others for as long as the same model is asked about.
    """

    candidates: tuple[Candidate, ...]
    _kept: dict[str, tuple[Columns, ...]] = field(default_factory=dict)
    _beside: WeakKeyDictionary[FittedModel, dict[str, tuple[Columns, ...]]] = field(default_factory=WeakKeyDictionary)

    @property
    def effects(self) -> tuple[Candidate, ...]:
        """The candidates without other readings of torques, which are a question of their own."""
        return tuple(candidate for candidate in self.candidates if not candidate.reads_torque)

    def narrow(self, name: str, nodes: Float) -> None:
        """From now on let the candidate called `name` have these nodes (R, V, S) alone."""
        self.candidates = tuple(replace(c, nodes=nodes) if c.name == name else c for c in self.candidates)
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
        same = not transforms(fitted.model.terms)  # as no late sensor shows them
        known = same and candidate.name in self._kept
        columns = self._kept[candidate.name] if known else _columns(candidate, fitted)
        fine = candidate.nodes.shape[1] > FINE
        if same and not candidate.tangent and (fine or not feeds_back(candidate.term)):
            # No number of the model changes them, or it takes long.
            self._kept[candidate.name] = columns
            return columns
        if fitted not in self._beside:
            self._beside.clear()
        self._beside.setdefault(fitted, {})[candidate.name] = columns
        return columns


def _columns(candidate: Candidate, fitted: FittedModel) -> tuple[Columns, ...]:
    """Columns of a candidate on every recording; those of many nodes are computed when they are asked for."""
    each = tuple(zip(candidate.nodes, fitted.prepared.all, strict=True))
    if candidate.nodes.shape[1] * candidate.width * len(candidate.joints) > MANY:
        return tuple(LateColumns(candidate, nodes, entry, fitted) for nodes, entry in each)
    return tuple(candidate_columns(candidate, nodes, entry, fitted) for nodes, entry in each)


def build_library(model: Model, prepared: Sequence[PreparedRecording], extra: Iterable[Effect] = ()) -> Library:
    """Return every effect of the catalogue, and the user's `extra` ones, at every joint where it exists.

    Terms that `model` already has are left out, what a person brings where it has no wearer, and effects of a drive, or
    of the model's own torque, at a joint that has no drive in any recording.
    """
    driven = driven_joints(prepared)
    found = []
    for effect in (*catalogue(model.joints, model.wearer is not None).values(), *extra):
        for joint in places_of(effect, model.joints):
            term = Term(effect, joint, model.joints, own_places=True)
            # Of a joint whose torque is always zero, the model's own torque is its residual: it would explain itself.
            undriven = joint is not None and not driven[term.first]
            idle = undriven and (effect.drive or (effect.derive is None and feeds_back(term)))
            if term.name not in model.effects and not idle:
                first = next(iter(effect.shape.values()), None)
                own = any(shape.per_recording for shape in effect.shape.values())
                tangent = not effect.coefficients and not own and first is not None and first.min <= 0.0 <= first.max
                found.append(Candidate(term, _nodes(term, prepared, tangent), tangent))
    return Library(tuple(found))


def _nodes(term: Term, prepared: Sequence[PreparedRecording], tangent: bool) -> Float:
    shapes = list(term.placed_shape.values())
    if tangent or not shapes:
        return np.zeros((len(prepared), 1, len(shapes)))
    shared = np.repeat(_product(shapes, term, prepared)[None], len(prepared), axis=0)
    if not any(shape.per_recording and not shape.turns for shape in shapes):
        return shared
    # Each recording at its own place, and all of them at the same one: where a recording hardly shows it, its own path
    # says little about where.
    return np.concatenate([[_product(shapes, term, [recording]) for recording in prepared], shared], axis=1)


def _product(shapes: Sequence[Shape], term: Term, paths: Sequence[PreparedRecording]) -> Float:
    """Nodes (V, S) of shapes on the paths of some recordings."""
    return np.array(list(itertools.product(*(_axis(shape, term, paths) for shape in shapes))), dtype=float)


def _axis(shape: Shape, term: Term, paths: Sequence[PreparedRecording]) -> Sequence[float]:
    if shape.choices:
        return shape.choices
    if shape.turns:  # another one for all recordings is other coefficients
        return (0.0,)
    if shape.spacing == "position" and term.joint is not None:
        return _places(shape, term, paths)
    if shape.spacing == "time":
        begin = min(float(p.motion.t[0]) for p in paths)
        lasts = max(float(p.motion.t[-1]) for p in paths) - begin
        far = [*MOMENTS, *(1.0 - moment for moment in MOMENTS)]
        return tuple(np.clip([begin + u * lasts for u in (*np.linspace(0.0, 1.0, 11), *far)], shape.min, shape.max))
    even = [from_unit(shape, u) for u in np.linspace(0.0, 1.0, max(2, shape.points))]
    middle = shape.spacing == "linear" and shape.min < 0.0 < shape.max and term.joint is not None
    if middle and shape.unit == term.among[term.first].unit("q"):  # where the joint gets to, it shows most
        return tuple(sorted({*even, *_places(shape, term, paths)}))
    return tuple(even)


def _places(shape: Shape, term: Term, paths: Sequence[PreparedRecording]) -> Sequence[float]:
    """Return places on the path of a term's joint, densest near the ends."""
    levels = sorted({*QUANTILES, *(round(1.0 - u, 6) for u in QUANTILES)})
    places = np.quantile(np.concatenate([p.motion.q[:, term.first] for p in paths]), levels)
    return [float(place) for place in np.clip(places, shape.min, shape.max)]
