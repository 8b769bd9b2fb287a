"""Friction that builds up over a small angle after each reversal instead of at once: c (z - sgn θ').

z is Dahl's state, or the mean of three slip elements (Maxwell, Iwan) that break away at 1/2, 1 and 2 times 1/σ: real
contacts come nearer to the one or to the other.
"""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect, Shape

SLIPS = " + ".join(f"(theta - play(theta, {h} / sigma)) * sigma / {h}" for h in ("0.5", "1", "2"))

EFFECT = Effect(
    id="hysteresis",
    title="Presliding hysteresis",
    family="friction",
    torque=f"c * ((1 - law) * dahl(theta, sigma) + law / 3 * ({SLIPS}) - sgn(dtheta))",
    coefficients={"c": Coefficient("N·m", min=0.0, typical=10.0, explains="Coulomb friction that builds up gradually")},
    shape={
        "sigma": Shape(
            "1/rad",
            min=10.0,
            max=500.0,
            spacing="log",
            points=7,
            typical=100.0,
            explains="inverse of the angle over which it builds up",
        ),
        "law": Shape("1", 0.0, 1.0, choices=(0.0, 1.0), typical=0.0, explains="0: Dahl, 1: three slip elements"),
    },
    explains=(
        "After a reversal the joint first deflects like a spring, and friction takes a small angle to "
        "reach its full size."
    ),
    tells_apart=("Many small reversals of different size, at speeds so low that viscous friction does not matter."),
    reference=(
        "Dahl, A solid friction model, Aerospace Corporation, report TOR-0158(3107-18)-1, 1968; "
        "Iwan, A distributed-element model for hysteresis, Journal of Applied Mechanics 33(4), 893-900, 1966"
    ),
)
