"""Check that an effect keeps what it declares: known names, units that fit, ordered bounds, linear in its coefficients.

Every Effect (`exoid.symbolic.effect`, above this file) is checked here when it is made, in a file of the catalogue,
from a model file or in a notebook. A torque is evaluated with one coefficient at one and the others at zero, so it has
to be linear *and* homogeneous in them: c * x is, c * x + 1, c**2 * x and abs(c) * x are not (linearity.py).
"""

from __future__ import annotations

import itertools
import keyword
import math
import re
from collections.abc import Collection, Iterator, Mapping
from typing import Any

from exoid.ground.errors import EffectError, ExpressionError
from exoid.symbolic.joints import MOST
from exoid.symbolic.language.deflection import deflected
from exoid.symbolic.language.dimensions import check_dimensions
from exoid.symbolic.language.linearity import check_proportional
from exoid.symbolic.language.tokens import refusal
from exoid.symbolic.language.tree import OPERATORS, Call, Node
from exoid.symbolic.language.words import MODEL_TORQUE, RESERVED, read_text, stem_of, word_dimension
from exoid.symbolic.quantity import JOINTS
from exoid.symbolic.units import FORCE, TORQUE, Dimension, dimension

_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
_ID = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,59}")


def check_effect(effect: Any) -> None:
    """Refuse an effect that contradicts itself: EffectError for a declaration, ExpressionError for a text."""
    _check_place(effect)
    for key in (*effect.coefficients, *effect.shape):
        _check_word(effect, key)
    for key, coefficient in effect.coefficients.items():
        _check_coefficient(f"{effect.id}.{key}", coefficient)
    for key, shape in effect.shape.items():
        _check_shape(f"{effect.id}.{key}", shape)
    if not (effect.coefficients or effect.shape):
        raise EffectError("no coefficient and no shape: nothing to identify", where=effect.id, remedy="declare one")
    numbers = (*effect.coefficients, *effect.shape)
    written = texts(effect) or tuple(text for _, text in deflected(effect.deflection or {}, 0))
    trees = [(text, read_text(text, not effect.on_both, numbers)) for text in written if text]
    used = frozenset().union(*(node.names() for _, node in trees))
    if trees and effect.coefficients and not used & effect.coefficients.keys():
        missing, (text, node) = " and ".join(effect.coefficients), trees[0]
        what = f"{missing} does not appear in the torque"
        raise refusal(what, text, node.span, "multiply every part by a coefficient")
    for key in numbers:
        if trees and key not in used:
            raise EffectError(
                f"{key} is declared but does not appear in the torque",
                where=f"{effect.id}: {'; '.join(written)}",
                remedy=f"use {key} in the text or drop its declaration",
            )
    for text, node in trees:
        _check_text(effect, text, node)


def texts(effect: Any) -> tuple[str, ...]:
    """Return the torque texts of an effect; none for a derived one."""
    if effect.torque is None:
        return ()
    return (effect.torque,) if isinstance(effect.torque, str) else tuple(effect.torque.values())


def _check_text(effect: Any, text: str, node: Node) -> None:
    """Check one torque text."""
    if effect.coefficients:
        check_proportional(node, text, effect.coefficients, "coefficient")
    else:
        named = {name for name in node.names() if stem_of(name) == "tau_model"}
        check_proportional(node, text, MODEL_TORQUE | named, "model torque")
    for call in _memory(node):
        varying = call.arguments[1].names() - effect.shape.keys() if len(call.arguments) > 1 else frozenset()
        if varying:
            raise refusal(
                f"the second argument of {call.function} depends on {', '.join(sorted(varying))}",
                text,
                call.arguments[1].span,
                "it is a number or a shape: the memory of a joint does not change while it moves",
            )
    numbers: dict[str, Any] = {**effect.coefficients, **effect.shape}
    units = {key: dimension(number.unit, effect.id) for key, number in numbers.items()}
    words = [name for name in node.names() if name not in units]
    _check_units(text, node, words, units, effect.coefficients)


def _check_units(
    text: str, node: Node, words: Collection[str], units: Mapping[str, Dimension], coefficients: Collection[str]
) -> None:
    """Refuse a text whose units fit at no joint: which joints turn and which slide is seen when it becomes a term."""
    of = {word: word.removeprefix(stem_of(word) or word) for word in words}
    others = sorted({*of.values()} - {""})[: MOST - 1]
    first: ExpressionError | None = None
    for turns in itertools.product((True, False), repeat=1 + len(others)):
        kinds = dict(zip(("", *others), turns, strict=True))
        known = {word: word_dimension(word, kinds.get(joint, True)) for word, joint in of.items()}
        try:
            return check_dimensions(node, text, {**known, **units}, TORQUE if turns[0] else FORCE, coefficients)
        except ExpressionError as error:
            first = first or error
    assert first is not None
    raise first


def _memory(node: Node) -> Iterator[Call]:
    return (part for part in node.walk() if isinstance(part, Call) and part.function in OPERATORS)


def _check_place(effect: Any) -> None:
    """Check id, joints, and that the effect is given in exactly one way, for the joints it names."""
    if not _ID.fullmatch(effect.id) or keyword.iskeyword(effect.id):
        what = f"{effect.id[:60]!r} is not an effect's id: not a usable name"
        raise EffectError(what, where="id", remedy="use up to 60 letters, digits and _, beginning with a letter")
    joints = effect.joints
    named = all(_IDENTIFIER.fullmatch(joint) and joint != "both" for joint in joints)
    if joints != ("both",) and (not joints or len({*joints}) < len(joints) or not named):
        raise EffectError(f"joints are {joints!r}", where=effect.id, remedy='use names of joints, or "both"')
    if [effect.torque, effect.derive, effect.deflection].count(None) != 2:
        remedy = "give exactly one"
        raise EffectError(
            "an effect has either a torque text or derive() or a deflection", where=effect.id, remedy=remedy
        )
    if effect.deflection is not None and (effect.on_both or {*effect.deflection} != {*effect.coefficients}):
        raise EffectError(
            "a deflection belongs to one joint, with a text for each coefficient",
            where=effect.id,
            remedy='name the joints "hip", "knee" or both of these, and give {coefficient: angle}',
        )
    if effect.torque is None:
        return
    if effect.on_both == isinstance(effect.torque, str):
        raise EffectError(
            "one torque text does not fit its joints" if effect.on_both else "one text per joint is too many",
            where=effect.id,
            remedy='an effect on "both" has a text for hip and one for knee; any other has a single text',
        )
    if not isinstance(effect.torque, str) and not {*effect.torque} <= {*JOINTS}:
        raise EffectError(
            f"torque texts for {', '.join(effect.torque)}", where=effect.id, remedy="name them hip and knee"
        )


def _check_word(effect: Any, key: str) -> None:
    """Check the name of a coefficient or shape."""
    where = f"{effect.id}.{key}"
    if not _IDENTIFIER.fullmatch(key) or keyword.iskeyword(key):
        what = f"{key[:60]!r} is not a name"
        raise EffectError(what, where=where, remedy="use up to 40 ASCII letters, digits and _, beginning with a letter")
    if key in RESERVED or stem_of(key):
        remedy = "choose another name"
        raise EffectError(f"{key} already means something else in torque texts", where=where, remedy=remedy)
    if key in effect.coefficients and key in effect.shape:
        raise EffectError(f"{key} is declared as a coefficient and as a shape", where=where, remedy="keep one of them")


def _check_coefficient(where: str, coefficient: Any) -> None:
    """Check unit and bounds of a coefficient."""
    low = -math.inf if coefficient.min is None else coefficient.min
    high = math.inf if coefficient.max is None else coefficient.max
    _check_bounds(where, coefficient.unit, low, high, coefficient.typical)


def _check_shape(where: str, shape: Any) -> None:
    """Check unit, bounds, choices and grid of a shape."""
    if not (math.isfinite(shape.min) and math.isfinite(shape.max)):
        remedy = "give two finite numbers"
        raise EffectError(f"the bounds are {shape.min!r} and {shape.max!r}", where=where, remedy=remedy)
    _check_bounds(where, shape.unit, shape.min, shape.max, shape.typical)
    if not all(shape.min <= choice <= shape.max for choice in shape.choices):
        what = f"the choices {shape.choices!r} do not lie within the bounds"
        raise EffectError(what, where=where, remedy=f"use values from {shape.min:g} to {shape.max:g}")
    if shape.spacing not in ("linear", "log", "time", "position") or (shape.spacing == "log" and shape.min <= 0.0):
        what = f"spacing {shape.spacing!r} from {shape.min:g}"
        raise EffectError(what, where=where, remedy='use "linear", "position", "time", or "log" where min is positive')
    if shape.points < 1:
        raise EffectError(f"{shape.points} trial points", where=where, remedy="use one or more")


def _check_bounds(where: str, unit: str, low: float, high: float, typical: float | None) -> None:
    dimension(unit, where)
    if not low < high:
        raise EffectError(f"min {low:g} is not below max {high:g}", where=where, remedy="swap or mend them")
    if typical is not None and not low <= typical <= high:
        what = f"the typical value {typical:g} lies outside its bounds"
        raise EffectError(what, where=where, remedy=f"choose it from {low:g} to {high:g}")
