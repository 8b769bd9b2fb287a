"""A torque reading that creeps with time: c (t - t_0).

Nobody tares a sensor at the same moment of every recording: the moment t_0 at which it reads right belongs to the
recording, which is the same as an offset of its own, -c t_0.
"""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect, Shape

EFFECT = Effect(
    id="torque_drift",
    title="Torque drift",
    family="drift",
    drive=True,
    torque="c * (t - t_0)",
    coefficients={"c": Coefficient("N·m/s", typical=0.05, explains="drift of the reading")},
    shape={
        "t_0": Shape(
            "s",
            min=-1000.0,
            max=1000.0,
            spacing="time",
            points=41,
            typical=0.0,
            explains="when the sensor reads right: its zero in this recording is -c t_0",
            per_recording=True,
        )
    },
    explains="The zero of the torque sensor creeps while it is recorded, as it warms up or relaxes.",
    tells_apart=("Return to the same posture at rest every minute, and read the unloaded sensor before and after."),
    reference="Fraden, Handbook of Modern Sensors, Springer, 2010",
)
