"""A term's torque text at its joint: which names it may use, what it is linear in, what it needs to be
evaluated.

A text without coefficients that speaks of `tau_model` is a *transform*: it acts on the columns of the base
model instead of adding one of its own (a delay of the whole torque, a wrong gain of the drive).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from symbolic.language.deflection import SLOPES
from symbolic.language.words import FEEDBACK, MODEL_TORQUE, read_text

if TYPE_CHECKING:
    from symbolic.term import Term


@dataclass(frozen=True, eq=False)
class Torque:
    """The parsed text (`node`) of a term at joint index `joint`, with the names it uses."""

    joint: int
    text: str
    node: Any
    names: frozenset[str]


def torques(term: Term) -> tuple[Torque, ...]:
    """Return the parsed torque texts of a term; none where its effect changes the mechanism."""
    effect = term.effect
    numbers = (*effect.coefficients, *effect.shape)
    return tuple(_parsed(joint, text, not effect.on_both, numbers) for joint, text in term.texts)


@lru_cache(maxsize=1024)
def _parsed(joint: int, text: str, own: bool, numbers: tuple[str, ...]) -> Torque:
    node = read_text(text, own, numbers)
    return Torque(joint, text, node, node.names())


def is_transform(term: Term) -> bool:
    """Whether the term acts on the base model's columns."""
    if term.effect.derive is not None or term.effect.coefficients:
        return False
    return any(torque.names & MODEL_TORQUE for torque in torques(term))


def uses_slopes(term: Term) -> bool:
    """Whether the term's columns are made of derivatives of the model's own torque."""
    return any(torque.names & SLOPES for torque in torques(term))


def uses_feedback(term: Term) -> bool:
    """Whether the term's columns are computed from the model's own torque, hence from reference parameters."""
    return bool(term.effect.coefficients) and any(torque.names & FEEDBACK for torque in torques(term))
