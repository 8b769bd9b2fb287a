"""A damper between shank and pelvis: c (θ1' + θ2') on both joints."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect

EFFECT = Effect(
    id="cross_viscous",
    title="Damping across both joints",
    family="friction",
    joints=("both",),
    torque={"hip": "c * (dtheta1 + dtheta2)", "knee": "c * (dtheta1 + dtheta2)"},
    coefficients={
        "c": Coefficient("N·m·s/rad", min=0.0, typical=3.0, explains="damping of the second link's absolute rotation")
    },
    explains=(
        "Something resists the absolute rotation of the second link, such as a strap, a cable sheath or a fluid line "
        "to it from the base."
    ),
    tells_apart="Move the second joint with the first held: the first then feels its speed.",
    reference=(
        "Goldstein, Poole, Safko, Classical Mechanics, Addison-Wesley, 2002, section 1.5 (dissipation function)"
    ),
)
