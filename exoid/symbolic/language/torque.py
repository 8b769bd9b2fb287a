"""A term's torque text at its joint: which names it may use, what it is linear in, what it needs to be
evaluated.

A text without coefficients that speaks of `tau_model` is a *transform*: it acts on all columns of the model instead of
adding one of its own (a delay of the whole torque, a filter behind the sensor).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from exoid.symbolic.language.deflection import SLOPES
from exoid.symbolic.language.dimensions import check_dimensions
from exoid.symbolic.language.linearity import LINEAR_OPERATORS
from exoid.symbolic.language.tokens import refusal
from exoid.symbolic.language.tree import Binary, Call, Name, Node, Number, Unary, rebuilt
from exoid.symbolic.language.words import FEEDBACK, MODEL_TORQUE, joint_of, read_text, stem_of, word_dimension
from exoid.symbolic.units import FORCE, TORQUE, dimension

if TYPE_CHECKING:
    from exoid.symbolic.term import Term


@dataclass(frozen=True, eq=False)
class Torque:
    """The parsed text (`node`) of a term at joint index `joint`, with the names it uses."""

    joint: int
    text: str
    node: Any
    names: frozenset[str]


@lru_cache(maxsize=1024)
def torques(term: Term) -> tuple[Torque, ...]:
    """Return the torque texts of a term as trees whose words name joints by number (theta1, dtheta2); none where its
    effect changes the mechanism. ExpressionError for a word of a joint that the machine does not have.
    """
    effect = term.effect
    numbers = (*effect.coefficients, *effect.shape)
    names = tuple(joint.name for joint in term.among)
    return tuple(
        _parsed(joint, text, not effect.on_both, numbers, names, term.first if effect.on_both else 0)
        for joint, text in term.texts
    )


@lru_cache(maxsize=1024)
def _parsed(joint: int, text: str, own: bool, numbers: tuple[str, ...], names: tuple[str, ...], first: int) -> Torque:
    read = read_text(text, own, numbers)

    def numbered(node: Node) -> Node:
        if isinstance(node, Name):
            stem = stem_of(node.name)
            if stem is None or node.name in numbers:
                return node
            index = joint_of(node.name, joint, names) if own else _counted_from(first, node.name, names)
            if index is None:
                raise refusal(
                    f"unknown name {node.name!r}: there is no such joint", text, node.span,
                    f"the joints are {', '.join(f'{k + 1}: {name}' for k, name in enumerate(names))}",
                )  # fmt: skip
            return Name(f"{stem}{index + 1}", node.span)
        return rebuilt(node, numbered)

    node = numbered(read)
    return Torque(joint, text, node, node.names())


@lru_cache(maxsize=1024)
def part_of(torque: Torque, key: str, keys: tuple[str, ...]) -> Torque:
    """Return the factor of coefficient `key`, one of `keys`, in a torque: itself at one, the others at zero, and what
    is zero then left out.
    """
    values = {name: Number(float(name == key)) for name in keys}

    def part(node: Node) -> Node:
        if isinstance(node, Name):
            return values.get(node.name, node)
        node = rebuilt(node, part)
        if isinstance(node, Binary):
            return _without_zeros(node)
        gone = isinstance(node, Unary) or (isinstance(node, Call) and node.function in LINEAR_OPERATORS)
        return NOTHING if gone and node.children()[0] == NOTHING else node

    node = part(torque.node)
    return Torque(torque.joint, torque.text, node, node.names())


NOTHING, ONE = Number(0.0), Number(1.0)


def _without_zeros(node: Binary) -> Node:
    left, right = node.left, node.right
    if node.operator == "*" and NOTHING in (left, right):
        return NOTHING
    if node.operator == "*" and ONE in (left, right):
        return right if left == ONE else left
    if node.operator == "/" and left == NOTHING:
        return NOTHING
    if node.operator in "+-" and right == NOTHING:
        return left
    if node.operator in "+-" and left == NOTHING:
        return right if node.operator == "+" else Unary("-", right, node.span)
    return node


def _counted_from(first: int, word: str, names: tuple[str, ...]) -> int | None:
    """Return the joint of a word in an effect on two neighbours: 1 is the first of them."""
    index = joint_of(word, first, names)
    if index is None or word.endswith("]"):
        return index
    return index + first if index + first < len(names) else None


def check_units(term: Term) -> None:
    """Refuse a user's effect whose torque has not the unit of its joint: N·m where that turns, N where it slides."""
    effect = term.effect
    numbers: dict[str, Any] = {**effect.coefficients, **effect.shape}
    units = {key: dimension(number.unit, f"{effect.id}.{key}") for key, number in numbers.items()}
    turns = [joint.turns for joint in term.among]
    names = tuple(str(k + 1) for k in range(len(turns)))
    for torque in torques(term):
        of = {word: joint_of(word, torque.joint, names) for word in torque.names if word not in units}
        words = {word: word_dimension(word, index is None or turns[index]) for word, index in of.items()}
        wanted = TORQUE if turns[torque.joint] else FORCE
        check_dimensions(torque.node, torque.text, {**words, **units}, wanted, effect.coefficients)


def is_transform(term: Term) -> bool:
    """True if the term acts on the whole torque that the rest of the model says: a late or filtered sensor."""
    if term.effect.derive is not None or term.effect.coefficients:
        return False
    return any(torque.names & MODEL_TORQUE for torque in torques(term))


def by_stage(terms: Iterable[Term]) -> tuple[list[Term], list[Term]]:
    """The terms that make the machine's torque, and the transforms that then act on it, each in their order."""
    every = list(terms)
    return [term for term in every if not is_transform(term)], transforms(every)


def transforms(terms: Iterable[Term]) -> list[Term]:
    """The transforms among terms, in their order."""
    return [term for term in terms if is_transform(term)]


def uses_slopes(term: Term) -> bool:
    """True if the term's columns are made of derivatives of the model's own torque."""
    return any(torque.names & SLOPES for torque in torques(term))


def uses_feedback(term: Term) -> bool:
    """True if the term's columns are computed from the model's own torque, hence from reference parameters."""
    return bool(term.effect.coefficients) and any(torque.names & FEEDBACK for torque in torques(term))
