"""The friction every model has: τ_f = k_1 sgn θ' + k_2 θ' at each joint (equation (4) of the paper).

The paper prints kg·m² behind these four numbers; Coulomb friction is a torque, viscous friction a torque
per velocity.
"""

from __future__ import annotations

from symbolic.effect import Coefficient, Effect
from symbolic.term import Parameter, Term

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

FRICTION = (Term(COULOMB, "hip"), Term(VISCOUS, "hip"), Term(COULOMB, "knee"), Term(VISCOUS, "knee"))
"""The friction terms of every model, in the order of the paper's Φ5 to Φ8."""


def friction_parameters() -> tuple[Parameter, ...]:
    """Return the four friction parameters; they have the name of their term, being its only number."""
    parameters = []
    for place, term in zip(("11", "12", "21", "22"), FRICTION, strict=True):
        (single,) = term.parameters
        parameters.append(
            Parameter(
                name=term.name,
                label=f"{term.effect.title} {term.joint}",
                unit=single.unit,
                min=single.min,
                max=single.max,
                latex=f"k_{{{place}}}",
                term=None,
                typical=single.typical,
            )
        )
    return tuple(parameters)
