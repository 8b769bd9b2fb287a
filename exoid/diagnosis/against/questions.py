"""Possible differences of before and after: every effect of the catalogue, every number of the model, a load.

Each is asked twice: as something that acts only after (a change), and as something that has acted all along (an old
error, which another motion may merely have made visible). The columns of a change are zero before.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate, candidate_columns
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.library import Library, build_library
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.symbolic.effect import Coefficient, Effect, Shape
from exoid.symbolic.language.torque import torques
from exoid.symbolic.mechanics.payload import LINKS, Payload
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float
from exoid.symbolic.term import Term

ALL_ALONG = " (all along)"
PLACES = (0.1, 0.2, 0.3, 0.4)
"""Places of a load on its link, m, from which its own is looked for."""
NEAREST, FARTHEST = 0.0, 0.8
"""Between which it lies, m from the upper joint of its link."""
NUMBER = Effect(
    id="changed_number",
    explains="a number of the model is another one afterwards",
    torque="c",
    coefficients={"c": Coefficient("N·m")},
)
LOAD = Effect(
    id="payload",
    explains="a mass was put on a link, or taken off",
    torque="m * sin(theta + along)",
    coefficients={"m": Coefficient("N·m")},
    shape={"along": Shape("rad", -3.0, 3.0)},
)
"""Only the numbers of these two are used; their columns come from the model's own."""


@dataclass(frozen=True, eq=False)
class Asked(Candidate):
    """A candidate under its own `label`: a change, or the same `always`.

    `number` is the column of the model whose parameter changes, `link` the link that carries a load.
    """

    label: str = ""
    always: bool = False
    number: int | None = None
    link: str | None = None

    @property
    def name(self) -> str:
        """The label; an error that was always there says so."""
        return self.label + ALL_ALONG if self.always else self.label

    @property
    def kind(self) -> str:
        """Return "number", "load", "sensor" or "effect"."""
        if self.number is not None:
            return "number"
        if self.link is not None:
            return "load"
        return "sensor" if self.term.effect.family == "sensor" else "effect"

    def load(self, model: Model, base: Float, places: Sequence[float] = PLACES) -> Float:
        """Return the columns (V, J, K) of 1 kg at each of `places`, from the model's (J, K, P)."""
        assert self.link is not None
        added = np.array([Payload(1.0, along, self.link).numbers(model.thigh_length) for along in places])
        return np.moveaxis(base[:, :, : added.shape[1]] @ added.T, 2, 0)

    def placed(self, model: Model, base: Float, place: float) -> Float:
        """Return the columns (J, K, 2) of 1 kg at `place` m, and of their slope by the place."""
        # What a mass adds is quadratic in its place: the difference is the slope.
        before, middle, after = self.load(model, base, (place - 0.5, place, place + 0.5))
        return np.stack([middle, after - before], axis=2)


@dataclass(eq=False)
class Questions(Library):
    """All that is asked of recordings of which the first `before` were made before."""

    before: int = 0
    base: Sequence[Float] = ()
    """Columns (J, K, P) of the model on every recording."""
    raw: dict[tuple[str, int], Columns] = field(default_factory=dict)

    def columns(self, candidate: Candidate, fitted: FittedModel) -> tuple[Columns, ...]:
        """Return the columns on every recording; a change does not act before."""
        assert isinstance(candidate, Asked)
        count = len(self.base)
        if candidate.always:
            return tuple(self._on(candidate, k, fitted) for k in range(count))
        after = [self._on(candidate, k, fitted) for k in range(self.before, count)]
        nodes, width = after[0].values.shape[0], after[0].values.shape[3]
        joints = after[0].joints
        shapes = [(nodes, len(joints), own.shape[1], width) for own in self.base[: self.before]]
        return (*(Columns.absent(joints, shape) for shape in shapes), *after)

    def _on(self, candidate: Asked, index: int, fitted: FittedModel) -> Columns:
        """Return the columns on one recording as if the candidate acted there."""
        key = candidate.label, index
        if key not in self.raw:
            self.raw[key] = self.at(candidate, candidate.nodes[index], index, fitted)
        return self.raw[key]

    def at(self, candidate: Asked, nodes: Float, index: int, fitted: FittedModel) -> Columns:
        """Return the columns at `nodes` (V, S) on one recording as if the candidate acted there."""
        return columns_on(candidate, nodes, fitted.prepared.all[index], self.base[index], fitted)


def columns_on(
    candidate: Asked, nodes: Float, one: PreparedRecording, base: Float, fitted: FittedModel
) -> Columns:
    """Return the columns at `nodes` (V, S) on any recording, on which the model's are `base`, as if it acted there."""
    joints = tuple(range(len(fitted.model.joints)))
    if candidate.number is not None:
        return Columns(joints, base[None, :, :, [candidate.number]])
    if candidate.link is not None:
        return Columns(joints, candidate.load(fitted.model, base, tuple(nodes[:, 0]))[..., None])
    plain = Candidate(candidate.term, candidate.nodes, candidate.tangent)
    return candidate_columns(plain, nodes, one, fitted)


@dataclass(frozen=True, eq=False)
class Acting:
    """A change as it acts on any window: what was `asked`, at `nodes` (1, S) or of a load at `place` m, and how much of
    each of its columns there is, `size` (m,).
    """

    asked: Asked
    nodes: Float
    place: float | None
    size: Float

    def columns(self, one: PreparedRecording, base: Float, fitted: FittedModel) -> Float:
        """Return its columns (J, K, m) on a window, on which the model's are `base` (J, K, P)."""
        if self.place is not None:
            return self.asked.placed(fitted.model, base, self.place)
        return columns_on(self.asked, self.nodes, one, base, fitted).full(0, len(fitted.model.joints))

    def torque(self, one: PreparedRecording, base: Float, fitted: FittedModel) -> Float:
        """Return the torque (J, K) that it adds."""
        return np.asarray(self.columns(one, base, fitted) @ self.size)

    def scaled(self, size: Float) -> Acting:
        """Return the same with other sizes (m,)."""
        return replace(self, size=size)


def questions(
    fitted: FittedModel, base: Sequence[Float], before: int, extra: Iterable[Effect] = (), *, always: bool = True
) -> Questions:
    """Return all questions about the recordings of `fitted`, of which the first `before` were made before.

    `base` are the model's columns (J, K, P + S) on each, slopes by its shapes included. Effects that drift with the
    time of a recording are left out: how a change came about is asked of its course. Without `always`, only changes.
    """
    model, prepared = fitted.model, fitted.prepared.all
    found: list[Asked] = []
    for own in build_library(model, prepared, extra).candidates:
        if _tells_time(own.term):
            continue
        nodes = own.nodes[:, own.common] if own.common.size else own.nodes
        found.append(Asked(own.term, nodes, own.tangent, own.name))
    if always:
        found += [replace(item, always=True) for item in found]
    count = len(prepared)
    names = [p.name for p in model.parameters] + [s.name for s in model.shapes]
    for k, name in enumerate(names):
        if k >= len(model.parameters) and model.shapes[k - len(model.parameters)].shape.choices:
            continue
        place = Term(NUMBER, model.joint_names[0], model.joints)
        found.append(Asked(place, np.zeros((count, 1, 0)), False, name, number=k))
    if not model.chain:
        nodes = np.broadcast_to(np.array(PLACES)[None, :, None], (count, len(PLACES), 1))
        for link in LINKS:
            found.append(Asked(Term(LOAD, model.joint_names[0]), nodes, False, f"payload:{link}", link=link))
    return Questions(tuple(found), before=before, base=tuple(base))


def _tells_time(term: Term) -> bool:
    if term.effect.derive is not None or term.effect.deflection is not None:
        return False
    return any("t" in torque.names for torque in torques(term))
