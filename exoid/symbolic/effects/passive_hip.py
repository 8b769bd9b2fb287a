"""Passive elastic moment of a person's hip, as measured on persons whose muscles are relaxed.

Published with angles in degrees, hip and knee flexion positive, and the moment that flexes the hip positive:

    exp(1.4655 - 0.0034 φk - 0.0750 φh) - exp(1.3403 - 0.0226 φk + 0.0305 φh) + 8.072 N·m .

The knee of a leg counts the other way round, and the drive has to hold what the muscles pull.
"""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect

EFFECT = Effect(
    id="passive_hip",
    title="Passive moment of the wearer's hip",
    family="spring",
    joints=("hip",),
    torque=(
        "-c * (exp(1.4655 + (0.0034 * theta[knee] - 0.075 * theta[hip]) * 180 / pi)"
        " - exp(1.3403 + (0.0226 * theta[knee] + 0.0305 * theta[hip]) * 180 / pi) + 8.072)"
    ),
    coefficients={"c": Coefficient("N·m", min=0.0, typical=1.0, explains="times the published moment")},
    explains="Relaxed muscles and ligaments of the wearer flex a hip that is extended, and extend one that is flexed.",
    tells_apart="Repeat the motion without the wearer; or move the hip with the knee straight, then bent.",
    reference=(
        "Riener, Edrich, Identification of passive elastic joint moments in the lower extremities, "
        "Journal of Biomechanics 32(5), 539-544, 1999"
    ),
    worn=True,
)
