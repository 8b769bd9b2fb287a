"""A user's own effect from a `[[custom_effects]]` table: the same type, in the same torque language, as the
catalogue's.
"""

from __future__ import annotations

import keyword
import re
from typing import TYPE_CHECKING, Any

from symbolic.effect import Coefficient, Effect, Shape
from symbolic.language.torque import OWN
from symbolic.language.tree import CONSTANTS, FUNCTIONS, OPERATORS
from symbolic.quantity import JOINTS

if TYPE_CHECKING:
    from ground.toml_reader import Table

FIELDS = (
    "id", "joint", "torque", "coefficients", "shape", "explains", "title", "family", "tells_apart", "reference",
)  # fmt: skip

RESERVED = frozenset(("t", *CONSTANTS, *FUNCTIONS, *OPERATORS, *OWN, *(f"{word}{k}" for word in OWN for k in (1, 2))))
"""Words the torque language gives a meaning of its own."""


def read_custom_effect(entry: Table) -> Effect:
    """Return the effect a table defines; ModelFileError, EffectError or ExpressionError where it cannot be one."""
    from symbolic.catalogue import FAMILIES, catalogue
    from symbolic.language.torque import check_term
    from symbolic.term import Term

    if "derive" in entry.values:
        remedy = "write a Python file in symbolic/effects/ with derive(mechanism, symbols)"
        raise entry.error("derive", "an effect that changes the mechanism itself needs Python", remedy)
    entry.only(*FIELDS)
    id = _word(entry, "id", entry.text("id"))
    if id in catalogue():
        raise entry.error("id", f"{id!r} is an effect of the catalogue", "choose another id, or list it in [[effects]]")
    joints, torque = _torque(entry)
    family = entry.text("family", "other")
    if family not in (*FAMILIES, "other"):
        raise entry.error("family", f"unknown family {family!r}", "known: " + ", ".join(FAMILIES))
    effect = Effect(
        id=id,
        explains=entry.text("explains", "no explanation given"),
        torque=torque,
        joints=joints,
        coefficients={key: _coefficient(table) for key, table in _declared(entry, "coefficients")},
        shape={key: _shape(table) for key, table in _declared(entry, "shape")},
        family=family,
        title=entry.text("title", id.replace("_", " ")),
        tells_apart=entry.text("tells_apart", "not stated"),
        reference=entry.text("reference", "no reference given"),
        custom=True,
    )
    for joint in (None,) if effect.on_both else joints:
        check_term(Term(effect, joint))
    return effect


def _torque(entry: Table) -> tuple[tuple[str, ...], Any]:
    """Return the joints and the torque text, or a text per joint for an effect on both."""
    joint = entry.text("joint", "")
    if isinstance(entry.values.get("torque"), dict):
        table = entry.table("torque")
        table.only(*JOINTS)
        if joint not in ("", "both"):
            raise entry.error("joint", "a torque per joint acts on both joints", 'write joint = "both"')
        return ("both",), {name: table.text(name) for name in JOINTS if name in table.values}
    text = entry.text("torque")
    if joint == "both":
        remedy = 'write torque = { hip = "...", knee = "..." }'
        raise entry.error("torque", "an effect on both joints needs a text for each", remedy)
    if joint not in ("", *JOINTS):
        raise entry.error("joint", f"there is no joint {joint!r}", 'use "hip", "knee" or "both"')
    return (joint,) if joint else JOINTS, text


def _declared(entry: Table, key: str) -> list[tuple[str, Table]]:
    if key not in entry.values:
        return []
    table = entry.table(key)
    return [(_word(table, name, name), table.table(name)) for name in table.values]


def _word(entry: Table, key: str, word: str) -> str:
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,39}", word) or keyword.iskeyword(word):
        raise entry.error(key, f"{word!r} is not a usable name", "use up to 40 letters, digits and _, a letter first")
    if word in RESERVED:
        raise entry.error(key, f"{word!r} already has a meaning in torque texts", "choose another name")
    return word


def _coefficient(table: Table) -> Coefficient:
    table.only("unit", "min", "max", "typical", "explains")
    low, high = table.optional("min"), table.optional("max")
    if low is not None and high is not None and not low < high:
        raise table.error("min", f"min = {low:g} is not below max = {high:g}", "swap or mend them")
    return Coefficient(table.text("unit"), low, high, table.optional("typical"), table.text("explains", ""))


def _shape(table: Table) -> Shape:
    table.only("unit", "min", "max", "choices", "typical", "spacing", "points", "explains", "per_recording")
    choices = tuple(table.numbers("choices")) if "choices" in table.values else ()
    low = table.number("min", min(choices) if choices else None)
    high = table.number("max", max(choices) if choices else None)
    if not low < high:
        raise table.error("min", f"min = {low:g} is not below max = {high:g}", "swap or mend them")
    spacing = table.text("spacing", "linear")
    if spacing not in ("linear", "log", "position"):
        raise table.error("spacing", f"unknown spacing {spacing!r}", 'use "linear", "log" or "position"')
    if spacing == "log" and low <= 0.0:
        raise table.error("min", "logarithmic spacing needs min > 0", 'give a positive min, or spacing = "linear"')
    typical = table.optional("typical")
    if typical is not None and not low <= typical <= high:
        raise table.error("typical", f"typical = {typical:g} lies outside [{low:g}, {high:g}]", "move it inside")
    points = int(table.number("points", 9, above=0.0, below=1000.0))
    own = table.values.get("per_recording", False)
    if not isinstance(own, bool):
        raise table.error("per_recording", "per_recording is neither true nor false", "write true or false")
    return Shape(table.text("unit"), low, high, choices, spacing, points, typical, table.text("explains", ""), own)
