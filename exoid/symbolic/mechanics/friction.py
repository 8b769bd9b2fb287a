"""The friction every joint has: τ_f = k_1 sgn θ' + k_2 θ' (equation (4) of the paper), as two ordinary effects.

The paper prints kg·m² behind the leg's four numbers; Coulomb friction is a torque, viscous friction a torque
per velocity.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

from exoid.symbolic.effect import Coefficient, Effect
from exoid.symbolic.joints import LEG, Joint
from exoid.symbolic.term import Parameter, Term

COULOMB = Effect(
    id="coulomb",
    title="Coulomb friction",
    explains="The joint resists with the same torque at any speed.",
    torque="c * sgn(dtheta)",
    coefficients={"c": Coefficient("N·m", min=0.0, typical=1.0)},
    family="friction",
    tells_apart="Constant slow motion in both directions.",
    reference="Coulomb, Théorie des machines simples, 1785",
)

VISCOUS = Effect(
    id="viscous",
    title="Viscous friction",
    explains="The joint resists in proportion to its speed.",
    torque="c * dtheta",
    coefficients={"c": Coefficient("N·m·s/rad", min=0.0, typical=1.0)},
    family="friction",
    tells_apart="Constant speeds over a wide range.",
    reference="Armstrong-Hélouvry, Dupont, Canudas de Wit, Automatica 30(7), 1994",
)


@lru_cache(maxsize=64)
def friction(joints: tuple[Joint, ...] = LEG) -> tuple[Term, ...]:
    """Return Coulomb and viscous friction of every joint; for the leg in the order of the paper's Φ5 to Φ8."""
    return tuple(Term(effect, joint.name, joints) for joint in joints for effect in (COULOMB, VISCOUS))


def friction_parameters(joints: tuple[Joint, ...] = LEG) -> tuple[Parameter, ...]:
    """Return the friction parameters (2 J,); they have the name of their term, being its only number."""
    return tuple(replace(term.parameters[0], name=term.name, term=None) for term in friction(joints))
