"""Rivals whose torques are the same at every state: why no motion can distinguish them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from exoid.ground.plain import AsJson
from exoid.symbolic.identifiability import structural_look_alikes
from exoid.symbolic.model import Model
from exoid.symbolic.term import Term


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
            ways = _other_ways(names[first], names[second])
            found.append(Same(first, second, alike.relation.removesuffix(", up to numbers of the model"), ways))
    for name, relations in absorbed.items():
        numbers = {*names[name].effect.coefficients, *names[name].effect.shape}
        if len(relations) == len(numbers):
            found.append(Same(name, "", "; ".join(relations), _other_ways(names[name])))
    return tuple(found)


def _other_ways(*rivals: Term) -> tuple[str, ...]:
    """Experiments by which the catalogue distinguishes rivals, in words."""
    known = "the catalogue on {} (a motion it names does not help here): {}"
    return tuple(known.format(term.name, term.effect.tells_apart) for term in rivals if term.effect.tells_apart)
