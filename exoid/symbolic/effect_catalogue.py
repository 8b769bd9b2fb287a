"""The catalogue: every effect found in `effects/`, by id."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from exoid.ground.errors import EffectError, ExpressionError
from exoid.ground.folder import names_in
from exoid.ground.suggest import nearest
from exoid.symbolic import effects
from exoid.symbolic.effect import Effect
from exoid.symbolic.joints import LEG, Joint
from exoid.symbolic.term import Term, places_of

FAMILIES = ("friction", "spring", "inertia", "gravity", "sensor", "drive", "drift", "contact", "base")
"""Families in the order in which the catalogue lists them."""


@cache
def catalogue(joints: tuple[Joint, ...] = LEG, worn: bool = True) -> Mapping[str, Effect]:
    """Return {id: effect} of the effects that a machine with these joints may have, by family, then id; those that a
    person brings only where it is `worn`.

    EffectError for a file that defines none.
    """
    found = [_load(name) for name in names_in(effects)]
    ordered = sorted(found, key=lambda effect: (FAMILIES.index(effect.family), effect.id))
    had = [effect for effect in ordered if (worn or not effect.worn) and (not joints or places_of(effect, joints))]
    return MappingProxyType({effect.id: effect for effect in had})


def every_effect() -> Mapping[str, Effect]:
    """Return {id: effect}, whichever machine has them."""
    return catalogue(())


def find_effect(id: str) -> Effect:
    """Return the effect of that id; "stribeck:knee" is understood where the effect has a place at that joint.

    EffectError with the nearest ids where there is none, or with the joints it can have.
    """
    known = every_effect()
    name, colon, joint = str(id)[:80].partition(":")
    if name in known:
        if colon:
            Term(known[name], joint)
        return known[name]
    near = nearest(name, known)
    hint = f"did you mean {' or '.join(near)}?" if near else "the catalogue has: " + ", ".join(known)
    raise EffectError(f"there is no effect {name!r}", where="catalogue", remedy=hint)


def _load(name: str) -> Effect:
    """Import one file of the folder and return its EFFECT."""
    where = f"exoid/symbolic/effects/{name}.py"
    try:
        effect = getattr(importlib.import_module(f"{effects.__name__}.{name}"), "EFFECT", None)
    except (EffectError, ExpressionError) as error:
        what = f"the file does not define an effect: {error.what}"
        raise EffectError(what, where=where, remedy=error.remedy) from error
    if not isinstance(effect, Effect) or effect.id != name or effect.family not in FAMILIES:
        remedy = f'write EFFECT = Effect(id="{name}", ...) with a family of: {", ".join(FAMILIES)}'
        raise EffectError("the file does not define an EFFECT whose id is the file's name", where=where, remedy=remedy)
    return effect
