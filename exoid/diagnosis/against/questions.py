"""Possible differences of before and after: every effect of the catalogue, every number of the model, and what may
belong to recordings (`exoid.diagnosis.hypotheses.recordings`): a load, a zero, a gain, a level of friction.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate, candidate_columns
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.library import build_library
from exoid.diagnosis.hypotheses.recordings import Claim, Seen, claims_of, nothing
from exoid.diagnosis.hypotheses.recordings.friction_level import BASE
from exoid.optimisation.preparation.filtering import PreparedRecording, driven_joints
from exoid.symbolic.effect import Effect
from exoid.symbolic.language.torque import torques
from exoid.symbolic.motion import Float
from exoid.symbolic.term import Term

ANY = (-np.inf, np.inf)
LOAD, LEVEL = "payload", "friction_level"
TOLD = {
    "carried_load": (LOAD, "load", "mass"),
    "friction_level": (LEVEL, "number", "level"),
    "sensor_zero": ("torque_offset", "sensor", "c"),
    "torque_gain": ("drive_gain", "effect", "c"),
}
"""{hypothesis: the name, the kind and the number under which it is told}; effects of that name are the same."""


@dataclass(frozen=True, eq=False)
class Asked:
    """Something that may change, by its `name`; `kind` is "number", "load", "sensor" or "effect".

    `numbers` {name: (unit, lowest, highest)} are its own, `nodes` (V, S) the values of its shape or place. It is a
    `candidate` of the catalogue, or a `claim` that recordings may have; of a number of the model, that is its `column`.
    """

    name: str
    kind: str
    numbers: dict[str, tuple[str, float, float]]
    nodes: Float
    candidate: Candidate | None = None
    claim: Claim | None = None
    column: int | None = None

    def columns(self, nodes: Float, one: PreparedRecording, base: Float, fitted: FittedModel) -> Columns:
        """Return its columns at `nodes` (V, S) on any recording, where the model has `base` (J, K, P), if it acts."""
        if self.candidate is not None:
            return candidate_columns(self.candidate, nodes, one, fitted)
        if self.column is not None:
            return Columns(tuple(range(len(base))), base[None, :, :, [self.column]])
        assert self.claim is not None
        own = base[:, :, : len(fitted.linear)]
        seen = Seen(fitted.model, fitted.linear, own, fitted.torque_on(one), one.t, one.logged, float(one.motion.t[0]))
        mixed = self.claim.pieces(seen) @ np.array([self.claim.mix(node) for node in nodes]).T
        return Columns(tuple(range(len(base))), np.moveaxis(mixed, 2, 0)[..., None])


@dataclass(frozen=True, eq=False)
class Acting:
    """A change as it acts on any window: the `size` (m,) of each column of what was `asked`, at `nodes` (1, S)."""

    asked: Asked
    nodes: Float
    size: Float

    def columns(self, one: PreparedRecording, base: Float, fitted: FittedModel) -> Float:
        """Return its columns (J, K, m) on a window, on which the model's are `base` (J, K, P)."""
        return self.asked.columns(self.nodes, one, base, fitted).full(0, len(base))

    def torque(self, one: PreparedRecording, base: Float, fitted: FittedModel) -> Float:
        """Return the torque (J, K) that it adds."""
        return np.asarray(self.columns(one, base, fitted) @ self.size)


def questions(fitted: FittedModel, extra: Iterable[Effect] = (), claims: Sequence[Claim] = ()) -> tuple[Asked, ...]:
    """Return all that may change on the recordings of `fitted`; `claims` are those about recordings, where they are
    made already.

    Effects that drift with the time of a recording are left out: how a change came about is asked of its course. What
    is dry or viscous of a friction level is a number of the model.
    """
    model, every = fitted.model, fitted.prepared.all
    claims = claims or claims_of(model, driven_joints(every))
    usual = [claim for claim in claims if claim.place and not (claim.common or claim.bends)]
    found = [_claimed(claim) for claim in usual if claim.of in ("", BASE)]
    names = [(p.name, p.unit, False) for p in model.parameters]
    names += [(s.name, s.shape.unit, bool(s.shape.choices)) for s in model.shapes]
    for k, (name, unit, chosen) in enumerate(names):
        if not chosen:
            claim = Claim("number", name, unit, nothing, ANY)
            found.append(Asked(name, "number", {name: (unit, *ANY)}, np.zeros((1, 1)), claim=claim, column=k))
    taken = {item.name for item in found}
    for own in build_library(model, every, extra).candidates:
        if own.name not in taken and not _tells_time(own.term):
            candidate = own.at_one_place if own.common.size else own
            kind = "sensor" if own.term.effect.family == "sensor" else "effect"
            found.append(Asked(own.name, kind, _numbers(own), candidate.nodes[0], candidate))
    return tuple(found)


def _claimed(claim: Claim) -> Asked:
    what, kind, number = TOLD.get(claim.what, (claim.what, "number", "size"))
    numbers = {number: (claim.unit, *claim.bounds)}
    return Asked(f"{what}:{claim.place}", kind, numbers, np.array(claim.nodes), claim=claim)


def _numbers(candidate: Candidate) -> dict[str, tuple[str, float, float]]:
    term = candidate.term
    if term.effect.coefficients:
        entries = term.effect.coefficients.items()
        bounds = {n: (-np.inf if e.min is None else e.min, np.inf if e.max is None else e.max) for n, e in entries}
        return {name: (term.unit(entry.unit), *bounds[name]) for name, entry in entries}
    name, shape = next(iter(term.placed_shape.items()))
    return {name: (term.unit(shape.unit), *ANY)}


def _tells_time(term: Term) -> bool:
    if term.effect.derive is not None or term.effect.deflection is not None:
        return False
    return any("t" in torque.names for torque in torques(term))
