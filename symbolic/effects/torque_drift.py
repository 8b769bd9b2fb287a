"""A torque reading that creeps with time: c t."""

from __future__ import annotations

from symbolic.effect import Coefficient, Effect

EFFECT = Effect(
    id="torque_drift",
    title="Torque drift",
    family="drift",
    drive=True,
    torque="c * t",
    coefficients={"c": Coefficient("N·m/s", typical=0.05, explains="drift of the reading")},
    explains="The zero of the torque sensor creeps while it is recorded, as it warms up or relaxes.",
    tells_apart=("Return to the same posture at rest every minute, and read the unloaded sensor before and after."),
    reference="Fraden, Handbook of Modern Sensors, Springer, 2010",
)
