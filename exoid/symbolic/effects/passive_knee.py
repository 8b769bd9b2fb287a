"""Passive elastic moment of a person's knee, as measured on persons whose muscles are relaxed, the ankle at 90°.

Published with angles in degrees, hip and knee flexion positive, and the moment that flexes the knee positive:

    exp(1.800 - 0.0352 φk + 0.0217 φh) - exp(-3.971 + 0.0495 φk - 0.0128 φh) + exp(2.220 - 0.150 φk) - 4.820 N·m .

The knee of a leg counts the other way round, and the drive has to hold what the muscles pull.
"""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect

EFFECT = Effect(
    id="passive_knee",
    title="Passive moment of the wearer's knee",
    family="spring",
    joints=("knee",),
    torque=(
        "c * (exp(1.8 + (0.0352 * theta[knee] + 0.0217 * theta[hip]) * 180 / pi)"
        " - exp(-3.971 - (0.0495 * theta[knee] + 0.0128 * theta[hip]) * 180 / pi)"
        " + exp(2.22 + 0.15 * theta[knee] * 180 / pi) - 4.82)"
    ),
    coefficients={"c": Coefficient("N·m", min=0.0, typical=1.0, explains="times the published moment")},
    explains="Relaxed muscles and ligaments of the wearer bend a knee that is straight, and stretch one that is bent.",
    tells_apart="Repeat the motion without the wearer; or move the knee with the hip stretched, then bent.",
    reference=(
        "Riener, Edrich, Identification of passive elastic joint moments in the lower extremities, "
        "Journal of Biomechanics 32(5), 539-544, 1999"
    ),
    worn=True,
)
