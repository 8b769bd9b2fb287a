"""Rivals whose torques are the same at every state: why no motion can distinguish them, and which change of set-up can.

A changed set-up is a second experiment with the same unknowns and something known added: a mass on the last link
changes the inertias by a known amount, a tilted stand turns gravity by a known angle. Whether the rivals still coincide
is computed: the derivatives of the torque by all numbers, at random states of both set-ups together, are laid side by
side as in exoid/symbolic/identifiability.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exoid.ground.errors import ExoidError
from exoid.ground.plain import AsJson
from exoid.symbolic.identifiability import Tangents, structural_look_alikes, tangents
from exoid.symbolic.mechanics.payload import Payload
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float
from exoid.symbolic.term import Term

MASS, REACH = 2.0, 0.30
"""kg and m down the last link of the known load that is tried."""
LEAN = 0.15
"""rad by which the stand is tilted."""
SAME = 1e-7
"""Relative remainder below which a torque counts as made of the others."""


@dataclass(frozen=True)
class Same(AsJson):
    """Two rivals that no motion can distinguish, and why (`second` is empty where the model contains `first`)."""

    first: str
    second: str
    relation: str
    ways: tuple[str, ...]

    @property
    def mutual(self) -> bool:
        """True if each can stand for the other; if not, `second` can always imitate `first`, but not the reverse."""
        return "is contained in" not in self.relation

    @property
    def sentence(self) -> str:
        """The finding for a person."""
        if not self.mutual:
            return (
                f"{self.second} can imitate {self.first} on any motion ({self.relation}); a motion can only show that "
                f"the other numbers of {self.second} are needed"
            )
        if not self.second:
            return f"{self.first} is contained in the model as it is ({self.relation}); no motion shows it"
        return f"{self.first} and {self.second} make the same torque ({self.relation}); no motion can distinguish them"


def same_torques(base: Model, rivals: Sequence[Term]) -> tuple[Same, ...]:
    """Return the rivals among `rivals` that the model `base` contains, and the pairs that make the same torque."""
    names = {term.name: term for term in rivals}
    found: list[Same] = []
    absorbed: dict[str, list[str]] = {}
    for alike in structural_look_alikes(base, rivals):
        if alike.absorbed:
            absorbed.setdefault(alike.names[0].rpartition(".")[0], []).append(alike.relation)
        elif set(alike.names) <= set(names):
            first, second = alike.names
            ways = other_ways(base, names[first], names[second])
            found.append(Same(first, second, alike.relation.removesuffix(", up to numbers of the model"), ways))
    for name, relations in absorbed.items():
        numbers = {*names[name].effect.coefficients, *names[name].effect.shape}
        if len(relations) == len(numbers):
            found.append(Same(name, "", "; ".join(relations), other_ways(base, names[name], None)))
    return tuple(found)


def other_ways(base: Model, one: Term, other: Term | None) -> tuple[str, ...]:
    """Other ways to distinguish two rivals (or one from the model), in words: computed, then the catalogue's."""
    out = []
    last = "shank" if not base.chain else base.joint_names[-1]
    for text, load, lean in (
        (f"hang a known mass on the {last} (computed for {MASS:g} kg), record again, name it (--payload)", True, False),
        (f"tilt the stand by a known angle (computed for {LEAN:g} rad) and record again", False, True),
    ):
        apart = _apart(base, one, other, load, lean)
        if apart is not None:
            out.append(text if apart else f"does not help (computed): {text}")
    out.sort(key=lambda text: text.startswith("does not"))
    out += [
        f"the catalogue on {term.name} (a motion it names does not help here): {term.effect.tells_apart}"
        for term in filter(None, (one, other))
        if term.effect.tells_apart
    ]
    if other is not None:
        out.append("static holds are motion too: what no motion distinguishes, they do not distinguish either")
    return tuple(dict.fromkeys(out))


def _apart(base: Model, one: Term, other: Term | None, load: bool, lean: bool) -> bool | None:
    """Answer to whether a second set-up separates the rivals; None where that cannot be computed."""
    terms = [*base.terms, one, *([other] if other is not None else [])]
    tilt = "gravity_tilt"
    try:
        model = replace(base, terms=tuple(terms))
        if lean and tilt not in {term.name for term in terms}:
            model = model.with_effect(tilt)
        whole = tangents(model)
        first, second = _setting(whole, model, False, False), _setting(whole, model, load, lean)
    except ExoidError:
        return None
    stacked = np.concatenate([first, second])
    mine = {term.name for term in terms}
    place = {name: k for k, name in enumerate(whole.names) if name.rpartition(".")[0] in mine or "." not in name}
    belongs = {term.name: [k for n, k in place.items() if n.startswith(f"{term.name}.")] for term in terms}
    old = [
        k for n, k in place.items() if k not in belongs[one.name] and (other is None or k not in belongs[other.name])
    ]
    if other is None:
        return not _inside(stacked[:, old], stacked[:, belongs[one.name]])
    rows = (one.name, other.name)
    return not any(_inside(stacked[:, [*old, *belongs[a]]], stacked[:, belongs[b]]) for a, b in (rows, rows[::-1]))


def _setting(whole: Tangents, model: Model, load: bool, lean: bool) -> Float:
    """Return the derivatives of the torque (rows, numbers) in one set-up."""
    function, inputs = whole.function, list(whole.inputs)
    linear, shape = np.array(inputs[-2]), np.array(inputs[-1])
    if load:
        added = Payload(MASS, (REACH, REACH, REACH) if model.spatial else REACH).added(model)
        linear[: len(added)] += added
    for k, entry in enumerate(model.shapes):
        if entry.term == "gravity_tilt":
            shape[k] = LEAN if lean else 0.0
    values = np.asarray(function(*inputs[:-2], linear, shape))
    count = len(whole.names)
    return np.moveaxis(values.reshape(count, len(model.joints), -1), 0, 2).reshape(-1, count)


def _inside(known: Float, columns: Float) -> bool:
    """True if every one of `columns` is a combination of the `known` ones."""
    scale = np.linalg.norm(known, axis=0)
    basis, triangle = np.linalg.qr(known / np.where(scale > 0.0, scale, 1.0))
    left, size, _ = np.linalg.svd(triangle)
    basis = basis @ left[:, : int(np.sum(size > 1e-10 * max(1.0, float(size[0]))))]
    rest = columns - basis @ (basis.T @ columns)
    return bool(np.all(np.linalg.norm(rest, axis=0) <= SAME * np.maximum(np.linalg.norm(columns, axis=0), 1e-300)))
