"""A gap between drive and joint: the link stays behind by h, to the side to which the load pushes it.

The side is the sign of the model's rigid-body torque, smoothed (below 1 Hz, over the load w) because the gap is not
crossed at once. To first order in h. What is elastic beside the drive and has a gap is `backlash`.
"""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect, Shape

EFFECT = Effect(
    id="series_backlash",
    title="Backlash of the drive",
    family="drive",
    drive=True,
    deflection={"h": "tanh(slow(tau_rigid, 1) / w)"},
    coefficients={"h": Coefficient("rad", min=0.0, typical=0.01, explains="half the width of the gap")},
    shape={
        "w": Shape(
            "N·m",
            min=0.2,
            max=10.0,
            spacing="log",
            points=9,
            typical=1.0,
            explains="load within which the gap is crossed",
            sharp=True,
        )
    },
    explains=(
        "There is a gap in the drive: whenever the load changes sides, the joint falls through it while the encoder "
        "at the motor stands still."
    ),
    tells_apart="Hold the motor and push the link to and fro by hand: it moves freely through the gap.",
    reference=(
        "Nordin, Gutman, Controlling mechanical systems with backlash: a survey, Automatica 38(10), 1633-1649, 2002"
    ),
)
