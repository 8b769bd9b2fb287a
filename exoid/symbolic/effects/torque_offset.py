"""A constant torque: c."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect

EFFECT = Effect(
    id="torque_offset",
    title="Torque offset",
    family="sensor",
    drive=True,
    torque="c",
    coefficients={"c": Coefficient("N·m", typical=3.0, explains="the offset")},
    explains=(
        "The torque sensor does not read zero at rest, or friction differs by a constant between the two directions."
    ),
    tells_apart="Read the torque sensor unloaded, before and after the recording.",
    reference=(
        "Swevers, Verdonck, De Schutter, Dynamic model identification for industrial robots, IEEE "
        "Control Systems Magazine 27(5), 58-71, 2007"
    ),
)
