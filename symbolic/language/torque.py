"""A term's torque text at its joint: which names it may use, what it is linear in, what it needs to be
evaluated.

A text without coefficients that speaks of `tau_model` is a *transform*: it acts on the columns of the base
model instead of adding one of its own (a delay of the whole torque, a wrong gain of the drive).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from ground.errors import EffectError
from symbolic.language.linearity import check_proportional

if TYPE_CHECKING:
    from symbolic.term import Term

OWN = ("theta", "dtheta", "ddtheta", "tau_rigid", "tau_model")
"""Words that mean the effect's own joint; with 1 or 2 behind them they mean hip or knee."""

FEEDBACK = frozenset(f"{stem}{index}" for stem in ("tau_rigid", "tau_model") for index in ("", "1", "2"))
"""Words for the model's own torque."""

MODEL_TORQUE = frozenset(("tau_model", "tau_model1", "tau_model2"))


@dataclass(frozen=True, eq=False)
class Torque:
    """The parsed text (`node`) of a term at joint index `joint`, with the names it uses."""

    joint: int
    text: str
    node: Any
    names: frozenset[str]


def torques(term: Term) -> tuple[Torque, ...]:
    """Parse the torque texts of a term; ExpressionError points at what the grammar refuses."""
    effect = term.effect
    own = "" if effect.on_both else ",".join(OWN)
    numbers = (*effect.coefficients, *effect.shape)
    return tuple(_parsed(joint, text, own, ",".join(numbers)) for joint, text in term.texts)


@lru_cache(maxsize=1024)
def _parsed(joint: int, text: str, own: str, numbers: str) -> Torque:
    from symbolic.language.parser import parse

    both = [f"{stem}{index}" for stem in OWN for index in (1, 2)]
    allowed = {"t", "pi", *both, *filter(None, own.split(",")), *filter(None, numbers.split(","))}
    node = parse(text, allowed)
    return Torque(joint, text, node, frozenset(node.names()))


def is_transform(term: Term) -> bool:
    """Whether the term acts on the base model's columns."""
    if term.effect.derive is not None or term.effect.coefficients:
        return False
    return any(torque.names & MODEL_TORQUE for torque in torques(term))


def uses_feedback(term: Term) -> bool:
    """Whether the term's columns are computed from the model's own torque, hence from reference parameters."""
    return bool(term.effect.coefficients) and any(torque.names & FEEDBACK for torque in torques(term))


def check_term(term: Term) -> None:
    """Refuse a term that has nothing to identify, or whose text the grammar refuses."""
    effect = term.effect
    if (effect.torque is None) == (effect.derive is None):
        raise EffectError("an effect has either a torque text or derive()", where=effect.id, remedy="give exactly one")
    parsed = torques(term)
    if effect.derive is not None:
        if not (effect.coefficients or effect.shape):
            raise EffectError("no coefficient and no shape: nothing to identify", where=effect.id, remedy="declare one")
        return
    used = frozenset().union(*(torque.names for torque in parsed))
    for key in (*effect.coefficients, *effect.shape):
        if key not in used:
            raise EffectError(
                f"{key} is declared but does not appear in the torque",
                where=f"{effect.id}: {'; '.join(torque.text for torque in parsed)}",
                remedy=f"use {key} in the text or drop its declaration",
            )
    unknowns, what = (effect.coefficients, "coefficient") if effect.coefficients else (MODEL_TORQUE, "model torque")
    if not effect.coefficients and not used & MODEL_TORQUE:
        raise EffectError(
            "the torque has no coefficient",
            where=f"{effect.id}: {'; '.join(torque.text for torque in parsed)}",
            remedy="multiply it by a coefficient and declare that with its unit",
        )
    for torque in parsed:
        check_proportional(torque.node, torque.text, unknowns, what)


def own_names(joint: int) -> dict[str, str]:
    """Return {word for the own joint: canonical word} at a joint index."""
    return {stem: f"{stem}{joint + 1}" for stem in OWN}
