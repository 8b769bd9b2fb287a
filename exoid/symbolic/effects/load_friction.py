"""Friction that grows with the load on the transmission: c |τ_rigid| sgn(θ')."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect

EFFECT = Effect(
    id="load_friction",
    title="Load-dependent friction",
    family="friction",
    drive=True,
    torque="c * abs(tau_rigid) * sgn(dtheta)",
    coefficients={"c": Coefficient("1", min=0.0, typical=0.07, explains="friction as a share of the load")},
    explains=("The more the gear carries, the harder it rubs: friction is a share of the torque passed on."),
    tells_apart=(
        "Slow motion with and without a known added mass; the friction must follow the load, not the position."
    ),
    reference=(
        "Hamon, Gautier, Garrec, Dynamic identification of robots with a dry friction model depending on "
        "load and velocity, IROS, 2010"
    ),
)
