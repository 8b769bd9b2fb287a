"""Passive torque of a human joint, rising steeply towards one end: ±c exp(±k θ).

The usual c exp(±k (θ - θ_s)) with θ_s = 0: another θ_s only rescales c, so that no data could tell them
apart.
"""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect, Shape

EFFECT = Effect(
    id="passive_exponential",
    title="Passive joint torque",
    family="spring",
    torque="c * side * exp(side * k * theta)",
    coefficients={"c": Coefficient("N·m", min=0.0, typical=1.0, explains="torque at angle zero")},
    shape={
        "k": Shape("1/rad", min=2.0, max=20.0, spacing="log", points=8, typical=2.5, explains="how steeply it rises"),
        "side": Shape(
            "1",
            min=-1.0,
            max=1.0,
            choices=(-1.0, 1.0),
            points=2,
            explains="+1: at large angles, -1: at small angles",
        ),
    },
    explains=(
        "Something resists more and more steeply towards one end of the range: muscles, ligaments and skin of a "
        "wearer, a sleeve."
    ),
    tells_apart=(
        "Move it slowly towards the end of the range, a wearer relaxed, with the other joint at two different angles."
    ),
    reference=(
        "Riener, Edrich, Identification of passive elastic joint moments in the lower extremities, "
        "Journal of Biomechanics 32(5), 539-544, 1999"
    ),
)
