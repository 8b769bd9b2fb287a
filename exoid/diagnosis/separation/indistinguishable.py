"""Rivals whose torques are the same at every state: why no motion can distinguish them, and which change of set-up can.

A changed set-up is a second experiment with the same unknowns and something known added: a mass on the last link
changes the inertias by a known amount, a tilted stand turns gravity by a known angle. Whether the rivals still coincide
is computed: the derivatives of the torque by all numbers, at random states of both set-ups together, are laid side by
side as in exoid/symbolic/identifiability.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import permutations

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
LEAN, TILT = 0.15, "gravity_tilt"
"""rad by which the stand is tilted, and the effect that this is."""
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
            ways = _other_ways(base, names[first], names[second])
            found.append(Same(first, second, alike.relation.removesuffix(", up to numbers of the model"), ways))
    for name, relations in absorbed.items():
        numbers = {*names[name].effect.coefficients, *names[name].effect.shape}
        if len(relations) == len(numbers):
            found.append(Same(name, "", "; ".join(relations), _other_ways(base, names[name])))
    return tuple(found)


def _other_ways(base: Model, *rivals: Term) -> tuple[str, ...]:
    """Other ways to distinguish two rivals (or one from the model), in words: computed, then the catalogue's."""
    last = "shank" if not base.chain else base.joint_names[-1]
    mass = f"hang a known mass on the {last} (computed for {MASS:g} kg), record again, name it (--payload)"
    lean = f"tilt the stand by a known angle (computed for {LEAN:g} rad) and record again"
    apart = {mass: _apart(base, rivals, load=True), lean: _apart(base, rivals, lean=True)}
    out = [way for way, helps in apart.items() if helps]
    out += [f"does not help (computed): {way}" for way, helps in apart.items() if helps is False]
    out += [
        f"the catalogue on {term.name} (a motion it names does not help here): {term.effect.tells_apart}"
        for term in rivals
        if term.effect.tells_apart
    ]
    if len(rivals) > 1:
        out.append("static holds are motion too: what no motion distinguishes, they do not distinguish either")
    return tuple(dict.fromkeys(out))


def _apart(base: Model, rivals: Sequence[Term], load: bool = False, lean: bool = False) -> bool | None:
    """Answer to whether a second set-up separates the rivals; None where that cannot be computed."""
    try:
        model = replace(base, terms=(*base.terms, *rivals))
        if lean and not any(term.name == TILT for term in model.terms):
            model = model.with_effect(TILT)
        whole = tangents(model)
        stacked = np.concatenate([_setting(whole, model), _setting(whole, model, load, lean)])
    except ExoidError:
        return None
    owners = [name.rpartition(".")[0] for name in whole.names]

    def of(*terms: str) -> Float:
        """Columns of what belongs to the `terms`, "" for the machine itself."""
        return stacked[:, [k for term in terms for k, owner in enumerate(owners) if owner == term]]

    known, names = ("", *(term.name for term in base.terms)), [term.name for term in rivals]
    if len(names) == 1:
        return not _inside(of(*known), of(*names))
    return not any(_inside(of(*known, a), of(b)) for a, b in permutations(names))


def _setting(whole: Tangents, model: Model, load: bool = False, lean: bool = False) -> Float:
    """Return the derivatives of the torque (rows, numbers) in one set-up."""
    *inputs, linear, shape = map(np.array, whole.inputs)
    if load:
        added = Payload(MASS, (REACH, REACH, REACH) if model.spatial else REACH).added(model)
        linear[: len(added)] += added
    shape[[entry.term == TILT for entry in model.shapes]] = LEAN if lean else 0.0
    count = len(whole.names)
    values = np.asarray(whole.function(*inputs, linear, shape)).reshape(count, len(model.joints), -1)
    return np.moveaxis(values, 0, 2).reshape(-1, count)


def _inside(known: Float, columns: Float) -> bool:
    """True if every one of `columns` is a combination of the `known` ones."""
    scale = np.linalg.norm(known, axis=0)
    left, size, _ = np.linalg.svd(known / np.where(scale > 0.0, scale, 1.0), full_matrices=False)
    basis = left[:, size > 1e-10 * max(1.0, float(size[0]))]
    rest = columns - basis @ (basis.T @ columns)
    return bool(np.all(np.linalg.norm(rest, axis=0) <= SAME * np.maximum(np.linalg.norm(columns, axis=0), 1e-300)))
