"""A user's own effect from a `[[custom_effects]]` table: the same type, in the same torque language, as the
catalogue's.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from exoid.ground.errors import EffectError, ExoidError
from exoid.symbolic.effect import Coefficient, Effect, Shape
from exoid.symbolic.effect_catalogue import FAMILIES, every_effect
from exoid.symbolic.joints import LEG, Joint
from exoid.symbolic.model_structure import check_custom
from exoid.symbolic.quantity import JOINTS

if TYPE_CHECKING:
    from exoid.ground.toml_reader import Table

FIELDS = (
    "id", "joint", "torque", "coefficients", "shape", "explains", "title", "family", "tells_apart", "reference",
)  # fmt: skip


def read_custom_effect(entry: Table, machine: tuple[Joint, ...] = LEG) -> Effect:
    """Return the effect a table defines for a machine; ModelFileError or ExpressionError where it cannot be one."""
    if "derive" in entry.values:
        remedy = "write a Python file in exoid/symbolic/effects/ with derive(mechanism, symbols)"
        raise entry.error("derive", "an effect that changes the mechanism itself needs Python", remedy)
    entry.only(*FIELDS)
    id = entry.text("id")
    if id in every_effect():
        raise entry.error("id", f"{id!r} is an effect of the catalogue", "choose another id, or list it in [[effects]]")
    joints, torque = _torque(entry, tuple(joint.name for joint in machine))
    family = entry.text("family", "other")
    if family not in (*FAMILIES, "other"):
        raise entry.error("family", f"unknown family {family!r}", "known: " + ", ".join(FAMILIES))
    parts: dict[str, Any] = {
        "coefficients": {key: _coefficient(table) for key, table in _declared(entry, "coefficients")},
        "shape": {key: _shape(table) for key, table in _declared(entry, "shape")},
    }
    try:
        effect = Effect(
            id=id,
            explains=entry.text("explains", "no explanation given"),
            torque=torque,
            joints=joints,
            family=family,
            title=entry.text("title", id.replace("_", " ")),
            tells_apart=entry.text("tells_apart", "not stated"),
            reference=entry.text("reference", "no reference given"),
            custom=True,
            **parts,
        )
        check_custom(effect, machine)
    except EffectError as error:
        raise _placed(entry, parts, error) from error
    return effect


def _placed(entry: Table, parts: Mapping[str, Mapping[str, Any]], error: EffectError) -> ExoidError:
    """Return the error with the line of the number, or of the key, that it speaks of."""
    name = error.where.rpartition(".")[2]
    for part, declared in parts.items():
        if name in declared:
            return entry.table(part).error(name, error.what, error.remedy)
    return entry.error("id" if error.where == "id" else "torque", error.what, error.remedy)


def _torque(entry: Table, names: tuple[str, ...]) -> tuple[tuple[str, ...], Any]:
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
    if joint not in ("", *names):
        known = ", ".join(f'"{name}"' for name in names)
        raise entry.error("joint", f"there is no joint {joint!r}", f'use {known} or "both"')
    return (joint,) if joint else JOINTS, text


def _declared(entry: Table, key: str) -> list[tuple[str, Table]]:
    if key not in entry.values:
        return []
    table = entry.table(key)
    return [(name, table.table(name)) for name in table.values]


def _coefficient(table: Table) -> Coefficient:
    table.only("unit", "min", "max", "typical", "explains")
    low, high, typical = (table.optional(key) for key in ("min", "max", "typical"))
    return Coefficient(table.text("unit"), low, high, typical, table.text("explains", ""))


def _shape(table: Table) -> Shape:
    table.only("unit", "min", "max", "choices", "typical", "spacing", "points", "explains", "per_recording")
    choices = tuple(table.numbers("choices")) if "choices" in table.values else ()
    low = table.number("min", min(choices) if choices else None)
    high = table.number("max", max(choices) if choices else None)
    points = int(table.number("points", 9, above=0.0, below=1000.0))
    own = table.flag("per_recording")
    spacing, typical = table.text("spacing", "linear"), table.optional("typical")
    return Shape(table.text("unit"), low, high, choices, spacing, points, typical, table.text("explains", ""), own)
