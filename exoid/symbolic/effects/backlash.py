"""An elastic transmission with a gap: c play(θ; h).

Without a gap (h = 0) play(θ; 0) = θ, and what is left is a plain spring of stiffness c.
"""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect, Shape

EFFECT = Effect(
    id="backlash",
    title="Backlash",
    family="contact",
    torque="c * play(theta, h)",
    coefficients={"c": Coefficient("N·m/rad", min=0.0, typical=10.0, explains="stiffness behind the gap")},
    shape={
        "h": Shape(
            "rad",
            min=0.001,
            max=0.1,
            spacing="log",
            points=9,
            typical=0.03,
            explains="half the width of the gap",
        )
    },
    explains="After a reversal the joint turns through a gap before the elastic part behind it follows.",
    tells_apart="Slow reversals of different size: within the gap the torque must stay the same.",
    reference=(
        "Nordin, Gutman, Controlling mechanical systems with backlash: a survey, Automatica 38(10), 1633-1649, 2002"
    ),
)
